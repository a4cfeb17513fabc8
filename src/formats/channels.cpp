#include "formats/channels.hpp"

#include <limits>

#include "base/log.hpp"
#include "formats/limits.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

std::string names_of(int components, bool colours) {
  const auto numbers = fmt::format("a number from 0 to {}", components - 1);
  if (!colours) return numbers;
  return components > 3 ? "r, g, b, a or " + numbers : "r, g, b or " + numbers;
}

template <class T>
T luminance(const T* colour) {
  if constexpr (std::is_integral_v<T>) {
    constexpr std::int64_t red = 2126, green = 7152, blue = 722, one = red + green + blue;
    const auto sum = red * colour[0] + green * colour[1] + blue * colour[2];
    return T((sum + (sum < 0 ? -one : one) / 2) / one);
  } else {
    return T(0.2126 * double(colour[0]) + 0.7152 * double(colour[1]) + 0.0722 * double(colour[2]));
  }
}

std::string listed_channels(std::int64_t count, const std::vector<ChannelNotes>& notes) {
  constexpr std::int64_t most = 10;
  std::vector<std::string> listed;
  for (std::int64_t c = 0; c < std::min(count, most); ++c) {
    const bool named = c < std::int64_t(notes.size()) && !notes[std::size_t(c)].name.empty();
    listed.push_back(named ? fmt::format("{} ({})", c, excerpt(notes[std::size_t(c)].name))
                           : std::to_string(c));
  }
  if (count > most) listed.emplace_back("...");
  return joined(listed);
}

class ChannelSource final : public ForwardingSource {
 public:
  ChannelSource(std::unique_ptr<VolumeSource> interleaved, const Grid& grid, int components,
                ChannelChoice choice)
      : ForwardingSource(std::move(interleaved), grid), components_(components), choice_(choice) {}

  /// Only a layer's interleaved voxels are held at a time.
  void read_slices(int first, int count, std::span<std::byte> out) override {
    const int depth = layer_depth();
    const auto bytes = grid().slice_bytes(Axis::z);
    std::vector<std::byte> layer;
    for (int z = first; z < first + count;) {
      const int end = std::min(first + count, (z / depth + 1) * depth);
      const auto wanted = out.subspan(std::size_t(z - first) * bytes, std::size_t(end - z) * bytes);
      layer.resize(wanted.size() * std::size_t(components_));
      ForwardingSource::read_slices(z, end - z, layer);
      take_channel(grid().type, components_, choice_, layer, wanted);
      z = end;
    }
  }

  Facts facts() const override {
    auto facts = ForwardingSource::facts();
    facts.push_back({"channel", choice_ ? fmt::format("{} of {}", *choice_, components_)
                                        : fmt::format("luminance of {}", components_)});
    return facts;
  }

 private:
  int components_;
  ChannelChoice choice_;
};

}  // namespace

int chosen_frame(const VolumeChoice& choice, int frames, const std::string& where, const char* things) {
  const int frame = choice.frame.value_or(0);
  if (frame >= 0 && frame < frames) return frame;
  throw InputError(fmt::format("--frame {}: {} holds {}", frame, where,
                               frames == 1 ? "one volume" : fmt::format("{} {}", frames, things)),
                   fmt::format("frames are numbered from 0 to {}", frames - 1));
}

ChannelChoice choose_channel(const std::string& channel, int components, bool colours,
                             const std::string& where) {
  if (channel.empty()) {
    if (!colours)
      refuse(where, fmt::format("choose one with --channel: {}", names_of(components, colours)),
             "a voxel is a vector of {} numbers", components);
    log_warning_once(
        "{}: voxels are colours, their luminance is shown; --channel r, g or b shows one of them", where);
    return {};
  }
  std::vector<ChannelNotes> letters;
  if (colours) letters = {{.name = "r"}, {.name = "g"}, {.name = "b"}, {.name = "a"}};
  const auto index = find_channel(channel, components, letters);
  if (!index && channel != "all")
    throw InputError(fmt::format("--channel {}: {} has no such channel", channel, where),
                     fmt::format("its channels are {}", names_of(components, colours)));
  return int(index.value_or(0));
}

std::int64_t choose_named_channel(const std::string& channel, std::int64_t count,
                                  const std::vector<ChannelNotes>& notes, const std::string& where) {
  if (channel.empty()) {
    log_warning_once("{}: of the channels {} the first is shown; --channel takes another, all draws all",
                     where, listed_channels(count, notes));
    return 0;
  }
  if (const auto found = find_channel(channel, count, notes)) return *found;
  if (channel == "all") return 0;
  throw InputError(fmt::format("--channel {}: {} has no such channel", channel, where),
                   "its channels are " + listed_channels(count, notes));
}

void take_channel(ScalarType type, int components, ChannelChoice choice, std::span<const std::byte> in,
                  std::span<std::byte> out) {
  visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    const auto* voxel = reinterpret_cast<const T*>(in.data());
    auto* taken = reinterpret_cast<T*>(out.data());
    auto* const end = taken + out.size() / sizeof(T);
    for (; taken != end; voxel += components, ++taken) *taken = choice ? voxel[*choice] : luminance(voxel);
  });
}

Grid interleaved_grid(const Grid& grid, int components, const std::string& where) {
  check_lattice(grid, where);
  if (components < 1 || grid.dims.x > std::numeric_limits<int>::max() / components)
    refuse(where, "correct the sizes in the header", "rows of {} voxels of {} numbers", grid.dims.x,
           components);
  Grid interleaved = grid;
  interleaved.dims.x *= components;
  check_lattice(interleaved, where);
  return interleaved;
}

std::unique_ptr<VolumeSource> channel_source(std::unique_ptr<VolumeSource> interleaved, const Grid& grid,
                                             int components, ChannelChoice choice) {
  if (components == 1) return interleaved;
  return std::make_unique<ChannelSource>(std::move(interleaved), grid, components, choice);
}

}  // namespace ringsplat::detail
