#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/nrrd/header.hpp"
#include "formats/stored_source.hpp"
#include "formats/text_reader.hpp"
#include "formats/volume_files.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

/// What an NRRD's axes are: at most three are the lattice's, one may come before these (its numbers are a
/// voxel's), others behind (whole volumes follow each other).
struct Layout {
  enum class Axis { none, frames, channels };

  Grid grid;        ///< in left-posterior-superior where the header tells the patient's axes
  int leading = 1;  ///< numbers in a voxel
  Axis leading_is = Axis::none;
  int frames = 1, channels = 1;                       ///< of all axes
  std::int64_t frame_stride = 0, channel_stride = 0;  ///< of axes behind, in volumes
  std::int64_t volumes = 1;                           ///< of all axes behind
  bool colours = false;                               ///< the leading axis is of red, green, blue and alpha
};

using Role = Layout::Axis;
using Axes = std::vector<NrrdAxis>;

constexpr int most_components = 4;  ///< of an axis of which nobody says what it is

/// Axes whose kind or missing direction says that they are not the lattice's.
bool is_declared_other(const NrrdHeader& header, const NrrdAxis& axis) {
  if (axis.kind != NrrdKind::unknown && axis.kind != NrrdKind::lattice) return true;
  return header.space_axes > 0 && axis.direction.empty();
}

Role role_of(const Axes& axes, std::size_t axis) {
  const auto kind = axes[axis].kind;
  if (kind == NrrdKind::unknown)
    return axis == 0 && axes[axis].size <= most_components ? Role::channels : Role::frames;
  return kind == NrrdKind::channels || kind == NrrdKind::colours ? Role::channels : Role::frames;
}

std::vector<std::size_t> lattice_axes(const NrrdHeader& header) {
  std::vector<std::size_t> axes;
  for (std::size_t i = 0; i < header.axes.size(); ++i)
    if (!is_declared_other(header, header.axes[i])) axes.push_back(i);
  if (axes.size() <= 3) return axes;
  // Nobody says so: a first axis as short as a colour, before long ones, is one.
  const auto& first = header.axes[0];
  const bool colours = axes.size() == 4 && axes[0] == 0 && first.kind == NrrdKind::unknown &&
                       first.size >= 3 && first.size <= most_components &&
                       std::all_of(axes.begin() + 1, axes.end(),
                                   [&](auto axis) { return header.axes[axis].size > most_components; });
  if (colours) axes.erase(axes.begin());
  axes.resize(3);
  return axes;
}

/// Where the first voxel's centre is when the header has no space: half a voxel behind a cell's beginning.
double first_centre(const NrrdAxis& axis) {
  const double steps = axis.nodes ? axis.size - 1 : axis.size;
  const double spacing = std::isnan(axis.spacing) ? (axis.max - axis.min) / steps : axis.spacing;
  return axis.min + (axis.nodes ? 0 : spacing / 2);
}

void place(const NrrdHeader& header, const std::vector<const NrrdAxis*>& axes, Grid& grid) {
  for (int i = 0; i < int(axes.size()); ++i) {
    const auto& axis = *axes[std::size_t(i)];
    grid.dims[i] = axis.size;
    if (!std::isnan(axis.spacing)) grid.spacing[i] = axis.spacing;
    if (axis.direction.empty()) continue;
    grid.spacing[i] = axis.length();
    grid.direction[i] = glm::dvec3(0);
    for (int k = 0; k < std::min(header.space_axes, 3); ++k)
      grid.direction[i][k] = axis.direction[std::size_t(k)] * (1.0 / grid.spacing[i]) * header.to_lps[k];
  }
  if (axes.size() == 2 && header.space_axes >= 3)
    grid.direction[2] = glm::normalize(glm::cross(grid.direction[0], grid.direction[1]));
  for (int k = 0; k < std::min<int>(int(header.origin.size()), 3); ++k)
    grid.origin[k] = header.origin[std::size_t(k)] * header.to_lps[k];
  const bool placed =
      header.space_axes == 0 && std::ranges::all_of(axes, [](const auto* axis) {
        return !std::isnan(axis->min) && !(std::isnan(axis->max) && std::isnan(axis->spacing));
      });
  for (int i = 0; placed && i < int(axes.size()); ++i) grid.origin[i] = first_centre(*axes[std::size_t(i)]);
}

void take_role(const NrrdHeader& header, Layout& layout, Role role, int size, std::int64_t stride) {
  int& count = role == Role::frames ? layout.frames : layout.channels;
  if (count > 1)
    header.fail(role == Role::frames ? "it has two axes of volumes" : "it has two axes of components");
  count = size;
  (role == Role::frames ? layout.frame_stride : layout.channel_stride) = stride;
}

/// Axes that are not the lattice's: those without a direction where the header has a space, those of a kind
/// that is no domain, the last beyond three. A kind of vector or colour is of channels, any other (time,
/// list, none) of frames. Throws InputError for axes of neither, between the lattice's, or several of one
/// role.
Layout layout_of(const NrrdHeader& header) {
  const auto lattice = lattice_axes(header);
  if (lattice.empty() || lattice.front() > 1) header.fail("its first axes are not the lattice's");
  if (lattice.back() - lattice.front() + 1 != lattice.size())
    header.fail("an axis lies between those of the lattice");
  Layout layout;
  layout.grid.type = header.type;
  layout.grid.dims = glm::ivec3(1);
  const auto axes = mapped(lattice, [&](std::size_t i) { return &header.axes[i]; });
  place(header, axes, layout.grid);
  check_lattice(layout.grid, header.path.string());
  if (lattice.front() == 1) {
    const auto& first = header.axes[0];
    layout.leading = first.size;
    layout.leading_is = role_of(header.axes, 0);
    layout.colours = first.kind == NrrdKind::colours
                         ? first.size == 3 || first.size == 4
                         : first.kind == NrrdKind::unknown && are_colours(header.type, first.size);
    if (layout.leading > 1) take_role(header, layout, layout.leading_is, layout.leading, 0);
  }
  for (auto i = lattice.back() + 1; i < header.axes.size(); ++i) {
    const int size = header.axes[i].size;
    if (size > 1) take_role(header, layout, role_of(header.axes, i), size, layout.volumes);
    layout.volumes *= size;
  }
  return layout;
}

[[noreturn]] void fail_data_file(const NrrdHeader& header) {
  fail_nrrd(header.path, fmt::format("its data file is '{}'", excerpt(header.data_file)));
}

using Names = std::vector<std::string>;

bool is_pattern(const std::string& name) {
  for (auto at = name.find('%'); at != std::string::npos; at = name.find('%', at + 1)) {
    const auto letter = name.find_first_not_of("0123456789", at + 1);
    if (letter != std::string::npos && name[letter] == 'd') return true;
  }
  return false;
}

/// How many files there must be, for pieces of as many axes; by default of all but the last.
void require_count(const NrrdHeader& header, std::size_t count, const std::optional<std::string>& piece) {
  const auto given = piece ? number_in<std::size_t>(*piece) : header.axes.size() - 1;
  if (!given || *given > header.axes.size() || (piece && *given == 0)) fail_data_file(header);
  const auto& axes = header.axes;
  std::uint64_t expected = 1;
  for (auto i = *given; i < axes.size(); ++i) expected *= std::uint64_t(axes[i].size);
  const bool fits =
      *given == axes.size() ? count > 0 && std::size_t(axes.back().size) % count == 0 : count == expected;
  if (!fits) fail_nrrd(header.path, fmt::format("it names {} data files, which do not fit its sizes", count));
}

Names names_of_pattern(const NrrdHeader& header) {
  const auto words = words_of(header.data_file);
  std::vector<std::int64_t> numbers;
  for (std::size_t i = 1; i < words.size() && i < 4; ++i)
    if (const auto number = number_in<std::int32_t>(words[i])) numbers.push_back(*number);
  if (numbers.size() != 3 || words.size() > 5 || numbers[2] == 0) fail_data_file(header);
  const auto first = numbers[0], last = numbers[1], step = numbers[2];
  const auto count = (last - first) / step + 1;
  constexpr std::int64_t most = 1 << 17;
  if ((last - first) * step < 0 || count > most) fail_data_file(header);
  const auto names = numbered_names(words[0], first, count, step);
  if (names.empty())
    refuse(header.path, "give a name with one number, such as slice%03d.raw 1 60 1",
           "the pattern of its data files is '{}'", excerpt(header.data_file));
  require_count(header, names.size(), words.size() > 4 ? std::optional(words[4]) : std::nullopt);
  return names;
}

/// The files that "data file" names: one, a list, or a pattern as "s%03d.raw 1 60 1"; the header's own when
/// it names none.
std::vector<std::filesystem::path> data_files_of(const NrrdHeader& header) {
  const auto& value = header.data_file;
  if (value.empty()) return {header.path};
  Names names{value};
  const auto words = words_of(value);
  if (is_pattern(value)) {
    names = names_of_pattern(header);
  } else if (value.starts_with("LIST")) {
    names = header.listed;
    const auto piece = trimmed(value.substr(4));
    require_count(header, names.size(), piece.empty() ? std::nullopt : std::optional(piece));
  }
  return mapped(names, [&](const auto& name) { return header.path.parent_path() / name; });
}

/// The byte of a file behind the skipped lines and, unless it is compressed, behind the skipped bytes.
std::uint64_t offset_in(const NrrdHeader& header, const std::filesystem::path& path,
                        std::uint64_t voxel_bytes) {
  const InputFile file(path);
  auto offset = header.end;
  if (header.line_skip > 0) {
    TextReader text(file, offset);
    for (std::int64_t k = 0; k < header.line_skip; ++k)
      if (!text.line()) require_bytes(path, file.size(), file.size(), voxel_bytes);
    offset = text.position();
  }
  if (header.encoding == Encoding::deflate) return offset;
  if (header.byte_skip >= 0) return offset + std::uint64_t(header.byte_skip);
  const auto behind = std::uint64_t(-1 - header.byte_skip);
  return file.size() - std::min(file.size(), voxel_bytes + behind);
}

/// The voxels of one file, which has `voxel_bytes` of them in all.
StoredVoxels stored_in(const NrrdHeader& header, const std::filesystem::path& file,
                       std::uint64_t voxel_bytes) {
  const bool gzip = header.encoding == Encoding::deflate;
  const auto written = header.encoding == Encoding::hex ? 2 * voxel_bytes : voxel_bytes;
  return {.file = file,
          .offset = offset_in(header, file, written),
          .encoding = header.encoding,
          .skip = gzip ? std::uint64_t(header.byte_skip) : 0,
          .big_endian = header.big_endian,
          .type = header.type};
}

/// One frame and channel of a file that has several.
std::unique_ptr<VolumeSource> source_of(const NrrdHeader& header, const Layout& layout,
                                        const std::vector<std::filesystem::path>& files,
                                        const VolumeChoice& choice) {
  const auto where = header.path.string();
  if (files.size() > 1 || header.encoding == Encoding::text || header.encoding == Encoding::hex)
    refuse(where, "write it anew in one file with encoding gzip or raw",
           "several volumes or components as {}", files.size() > 1 ? "several files" : "text");
  const auto wide = interleaved_grid(layout.grid, layout.leading, where);
  auto stored =
      stored_in(header, files[0], bytes_of_volumes(header.path, wide.bytes(), std::uint64_t(layout.volumes)));
  const int frame = chosen_frame(choice, layout.frames, where);
  const auto channel = layout.channels > 1
                           ? choose_channel(choice.channel, layout.channels, layout.colours, where)
                           : ChannelChoice(0);
  stored.choose(wide.bytes(), layout.volumes,
                frame * layout.frame_stride + channel.value_or(0) * layout.channel_stride);
  const bool of_frames = layout.leading_is == Layout::Axis::frames;
  return channel_source(stored_source(wide, {stored}), layout.grid, layout.leading,
                        of_frames ? ChannelChoice(frame) : channel);
}

}  // namespace

std::unique_ptr<VolumeSource> open_nrrd(const std::filesystem::path& path, const VolumeChoice& choice) {
  const auto header = read_nrrd_header(path);
  const auto files = data_files_of(header);
  const auto layout = layout_of(header);
  std::unique_ptr<VolumeSource> source;
  if (layout.leading > 1 || layout.volumes > 1) {
    source = source_of(header, layout, files, choice);
  } else {
    const auto bytes = layout.grid.bytes() / files.size();
    source = stored_source(layout.grid,
                           mapped(files, [&](const auto& file) { return stored_in(header, file, bytes); }));
  }
  VolumeNotes notes{.frames = layout.frames, .channels = layout.channels};
  if (header.patient) {
    notes.world = World::patient;
    notes.unit = "mm";
  }
  return with_notes(std::move(source), notes);
}

}  // namespace ringsplat::detail
