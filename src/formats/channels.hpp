#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/text.hpp"
#include "ringsplat/formats/open.hpp"
#include "ringsplat/volume/source.hpp"

/// Voxels of several numbers, of which one is taken, or the luminance of a colour.
namespace ringsplat::detail {

/// The number that is taken, from 0; nothing: the luminance of red, green and blue.
using ChannelChoice = std::optional<int>;

/// The number that --frame chooses of `frames`; throws InputError, which calls them `things`, for another.
int chosen_frame(const VolumeChoice& choice, int frames, const std::string& where,
                 const char* things = "volumes");

/// Three or four unsigned numbers of 8 or 16 bits are red, green, blue and alpha; other vectors are not.
inline bool are_colours(ScalarType type, int components) {
  return (components == 3 || components == 4) && (type == ScalarType::uint8 || type == ScalarType::uint16);
}

/// What `channel` (VolumeChoice's: a number, or r, g, b, a) takes of a voxel's `components` numbers. Without
/// it colours become their luminance, of which a warning tells. Throws InputError for no such channel, and
/// for vectors of which none is chosen. `where`: the file, for messages.
ChannelChoice choose_channel(const std::string& channel, int components, bool colours,
                             const std::string& where);

/// Of `count` channels the one with this name, in letters of any case, or else this number; nothing when
/// there is none. `notes`: some may be missing at the end.
inline std::optional<std::int64_t> find_channel(const std::string& channel, std::int64_t count,
                                                const std::vector<ChannelNotes>& notes) {
  for (std::size_t c = 0; c < notes.size() && std::int64_t(c) < count; ++c)
    if (lower_case(notes[c].name) == lower_case(channel)) return std::int64_t(c);
  const auto number = number_in<std::int64_t>(channel);
  return number && *number >= 0 && *number < count ? number : std::nullopt;
}

/// The same for channels that lie apart; without a choice the first, of which a warning tells. Throws
/// InputError for no such channel.
std::int64_t choose_named_channel(const std::string& channel, std::int64_t count,
                                  const std::vector<ChannelNotes>& notes, const std::string& where);

/// Takes the chosen numbers of interleaved voxels (native order). Luminance has the weights of ITU-R BT.709
/// on the stored numbers, rounded to the nearest of an integer type. `out` has in.size() / components bytes.
void take_channel(ScalarType type, int components, ChannelChoice choice, std::span<const std::byte> in,
                  std::span<std::byte> out);

/// The grid of a volume whose voxels are `components` numbers of grid.type, as a scalar volume with rows that
/// are so much longer: what readers of interleaved voxels are given. Throws InputError when that overflows,
/// and as check_lattice() does.
Grid interleaved_grid(const Grid& grid, int components, const std::string& where);

/// The scalar volume `grid` in a source of interleaved_grid(grid, components); that source itself for one.
std::unique_ptr<VolumeSource> channel_source(std::unique_ptr<VolumeSource> interleaved, const Grid& grid,
                                             int components, ChannelChoice choice);

/// The same by choose_channel() and are_colours().
inline std::unique_ptr<VolumeSource> channel_source(std::unique_ptr<VolumeSource> interleaved,
                                                    const Grid& grid, int components,
                                                    const std::string& channel, const std::string& where) {
  if (components == 1) return interleaved;
  const bool colours = are_colours(grid.type, components);
  return channel_source(std::move(interleaved), grid, components,
                        choose_channel(channel, components, colours, where));
}

}  // namespace ringsplat::detail
