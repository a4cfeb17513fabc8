#include "formats/nrrd/layout.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "formats/channels.hpp"
#include "formats/limits.hpp"

namespace ringsplat::detail {
namespace {

using Role = NrrdLayout::Axis;
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

/// The lattice's axes, at most three.
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

bool has_origin(const NrrdAxis& axis) {
  return !std::isnan(axis.min) && !(std::isnan(axis.max) && std::isnan(axis.spacing));
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
  const bool placed = header.space_axes == 0 && std::all_of(axes.begin(), axes.end(), [](const auto* axis) {
                        return has_origin(*axis);
                      });
  for (int i = 0; placed && i < int(axes.size()); ++i) grid.origin[i] = first_centre(*axes[std::size_t(i)]);
}

void take_role(const NrrdHeader& header, NrrdLayout& layout, Role role, int size, std::uint64_t stride) {
  int& count = role == Role::frames ? layout.frames : layout.channels;
  if (count > 1)
    header.fail(role == Role::frames ? "it has two axes of volumes" : "it has two axes of components");
  count = size;
  (role == Role::frames ? layout.frame_stride : layout.channel_stride) = stride;
}

}  // namespace

NrrdLayout nrrd_layout(const NrrdHeader& header) {
  const auto lattice = lattice_axes(header);
  if (lattice.empty() || lattice.front() > 1) header.fail("its first axes are not the lattice's");
  if (lattice.back() - lattice.front() + 1 != lattice.size())
    header.fail("an axis lies between those of the lattice");
  NrrdLayout layout;
  layout.grid.type = header.type;
  layout.grid.dims = glm::ivec3(1);
  std::vector<const NrrdAxis*> axes;
  for (const auto i : lattice) axes.push_back(&header.axes[i]);
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
    layout.volumes *= std::uint64_t(size);
  }
  return layout;
}

}  // namespace ringsplat::detail
