#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <string_view>

#include "base/printable.hpp"
#include "options/option_values.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

using Part = ClipText::Part;

constexpr std::string_view unit = "mm";

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

[[noreturn]] void refuse(const std::string& option, Axis axis, const Part& part, const std::string& why,
                         const std::string& hint) {
  throw InputError(fmt::format("{}: the {} part, '{}', {}", option, name(axis), part.text, why), hint);
}

/// One number, or nothing where the text is empty. False when it is no number.
bool take_number(std::string_view text, std::optional<double>& number) {
  text = trimmed(text);
  if (text.empty()) return true;
  const auto numbers = parse_numbers(text);
  if (!numbers || numbers->size() != 1 || !std::isfinite(numbers->front())) return false;
  number = numbers->front();
  return true;
}

Part parse_part(std::string_view text, const std::string& option, Axis axis) {
  Part part;
  part.text = printable(std::string(text));
  text = trimmed(text);
  if (text.ends_with(unit)) {
    part.distances = true;
    text.remove_suffix(unit.size());
  }
  if (trimmed(text).empty() && !part.distances) return part;
  const auto colon = text.find(':');
  if (colon == std::string_view::npos || !take_number(text.substr(0, colon), part.first) ||
      !take_number(text.substr(colon + 1), part.end))
    refuse(option, axis, part, "is no range", "give FIRST:END, FIRST:, :END, or nothing for all of the axis");
  return part;
}

/// The number of voxel faces up to a place, rounded to the nearest face.
int faces_to(double number, const Part& part, Axis axis, const ClipText& clip, const Grid& grid) {
  const int k = static_cast<int>(axis), last = grid.dims[k];
  if (!part.distances && number != std::floor(number))
    refuse(clip.option, axis, part, "has a voxel that is no whole number", "for distances add mm");
  const double voxel = grid.spacing[k] * glm::length(grid.direction[k]),
               faces = part.distances ? std::ceil(number / voxel - 0.5) : number;
  if (!(faces >= 0 && faces <= last))
    refuse(clip.option, axis, part, "does not lie within the volume",
           part.distances ? fmt::format("it is {:g} mm long there, from 0", last * voxel)
                          : fmt::format("it has voxels 0:{} there", last));
  return static_cast<int>(faces);
}

}  // namespace

ClipText parse_clip(const std::string& text, const std::string& option) {
  ClipText clip;
  clip.option = option;
  const auto parts = split(text, ",");
  if (parts.size() != clip.parts.size())
    throw InputError(fmt::format("{} '{}' has {} part{} instead of three", option, printable(text),
                                 parts.size(), parts.size() == 1 ? "" : "s"),
                     fmt::format("give x0:x1,y0:y1,z0:z1; for instance {} 10:200,:,0:64", option));
  for (const Axis axis : all_axes)
    clip.parts[std::size_t(axis)] = parse_part(parts[std::size_t(axis)], option, axis);
  if (clip.parts.back().distances)
    for (Part& part : clip.parts) part.distances = true;
  return clip;
}

VoxelBox clip_box(const ClipText& clip, const Grid& grid) {
  VoxelBox box = whole_box(grid);
  for (const Axis axis : all_axes) {
    const auto k = static_cast<int>(axis);
    const Part& part = clip.parts[std::size_t(axis)];
    if (part.first) box.first[k] = faces_to(*part.first, part, axis, clip, grid);
    if (part.end) box.end[k] = faces_to(*part.end, part, axis, clip, grid);
    if (box.first[k] >= box.end[k])
      refuse(clip.option, axis, part, "has no voxel",
             part.distances ? "a voxel counts when its centre lies between" : "FIRST must be less than END");
  }
  return box;
}

std::optional<VoxelBox> clip_box(const std::optional<ClipText>& clip, const Grid& grid) {
  return clip ? std::optional(clip_box(*clip, grid)) : std::nullopt;
}

}  // namespace ringsplat::app
