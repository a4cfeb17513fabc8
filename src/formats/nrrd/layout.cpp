#include "formats/nrrd/layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <limits>
#include <string>
#include <vector>

#include "formats/channels.hpp"
#include "formats/limits.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

using Role = NrrdLayout::Axis;

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
  throw InputError(fmt::format("{}: {}", path.string(), what),
                   "extract one volume, or write its axes as [component] x y z [time]");
}

ScalarType type_of(const Nrrd& nrrd, const std::filesystem::path& path) {
  switch (nrrd.type) {
    case nrrdTypeChar:
      return ScalarType::int8;
    case nrrdTypeUChar:
      return ScalarType::uint8;
    case nrrdTypeShort:
      return ScalarType::int16;
    case nrrdTypeUShort:
      return ScalarType::uint16;
    case nrrdTypeInt:
      return ScalarType::int32;
    case nrrdTypeUInt:
      return ScalarType::uint32;
    case nrrdTypeFloat:
      return ScalarType::float32;
    case nrrdTypeDouble:
      return ScalarType::float64;
    default:
      break;
  }
  throw InputError(
      fmt::format("{}: voxels of type {} cannot be rendered", path.string(), airEnumStr(nrrdType, nrrd.type)),
      "convert them to int32, uint32 or float32 first");
}

bool is_colour(int kind) {
  return kind == nrrdKind3Color || kind == nrrdKind4Color || kind == nrrdKindRGBColor ||
         kind == nrrdKindRGBAColor;
}

/// Axes whose kind or missing direction says that they are not the lattice's.
bool is_declared_other(const Nrrd& nrrd, unsigned axis) {
  const auto& info = nrrd.axis[axis];
  if (info.kind != nrrdKindUnknown && (nrrdKindIsDomain(info.kind) == 0 || info.kind == nrrdKindTime))
    return true;
  return nrrd.spaceDim > 0 && AIR_EXISTS(info.spaceDirection[0]) == 0;
}

Role role_of(const Nrrd& nrrd, unsigned axis) {
  const auto& info = nrrd.axis[axis];
  constexpr std::size_t most_components = 4;
  if (info.kind == nrrdKindTime || info.kind == nrrdKindList) return Role::frames;
  if (info.kind == nrrdKindUnknown)
    return axis == 0 && info.size <= most_components ? Role::channels : Role::frames;
  return nrrdKindIsDomain(info.kind) != 0 ? Role::frames : Role::channels;
}

/// The lattice's axes, at most three.
std::vector<unsigned> lattice_axes(const Nrrd& nrrd) {
  std::vector<unsigned> axes;
  for (unsigned axis = 0; axis < nrrd.dim; ++axis)
    if (!is_declared_other(nrrd, axis)) axes.push_back(axis);
  if (axes.size() <= 3) return axes;
  // Nobody says so: a first axis as short as a colour, before long ones, is one.
  const auto size = [&](unsigned axis) { return nrrd.axis[axis].size; };
  constexpr std::size_t most_components = 4;
  const bool colours =
      axes.size() == 4 && axes[0] == 0 && nrrd.axis[0].kind == nrrdKindUnknown && size(0) >= 3 &&
      size(0) <= most_components &&
      std::all_of(axes.begin() + 1, axes.end(), [&](unsigned axis) { return size(axis) > most_components; });
  if (colours) axes.erase(axes.begin());
  axes.resize(3);
  return axes;
}

/// As itk::NrrdImageIO has it, but for left-anterior-superior, which ITK 5.2 mirrors along the wrong axis.
Grid grid_of(const Nrrd& nrrd, const std::vector<unsigned>& axes, const std::filesystem::path& path) {
  Grid grid;
  grid.type = type_of(nrrd, path);
  grid.dims = glm::ivec3(1);
  glm::dvec3 to_lps(1);
  if (nrrd.space == nrrdSpaceRightAnteriorSuperior || nrrd.space == nrrdSpaceRightAnteriorSuperiorTime)
    to_lps = {-1, -1, 1};
  if (nrrd.space == nrrdSpaceLeftAnteriorSuperior || nrrd.space == nrrdSpaceLeftAnteriorSuperiorTime)
    to_lps = {1, -1, 1};
  std::array<unsigned, NRRD_DIM_MAX> indices{};
  for (int i = 0; i < int(axes.size()); ++i) {
    const auto axis = indices[std::size_t(i)] = axes[std::size_t(i)];
    grid.dims[i] = int(nrrd.axis[axis].size);
    double spacing = 1;
    std::array<double, NRRD_SPACE_DIM_MAX> direction{};
    const int status = nrrdSpacingCalculate(&nrrd, axis, &spacing, direction.data());
    if (status == nrrdSpacingStatusNone || status == nrrdSpacingStatusUnknown) continue;
    grid.spacing[i] = spacing;
    if (status != nrrdSpacingStatusDirection) continue;
    for (int k = 0; k < 3; ++k)
      grid.direction[i][k] = k < int(nrrd.spaceDim) ? direction[std::size_t(k)] * to_lps[k] : 0.0;
  }
  if (axes.size() == 2 && nrrd.spaceDim >= 3)
    grid.direction[2] = glm::normalize(glm::cross(grid.direction[0], grid.direction[1]));
  std::array<double, NRRD_DIM_MAX> origin{};
  const auto count = unsigned(axes.size());
  if (nrrd.spaceDim > 0) {
    if (AIR_EXISTS(nrrd.spaceOrigin[0]) != 0)
      for (int k = 0; k < int(std::min(nrrd.spaceDim, 3U)); ++k)
        grid.origin[k] = nrrd.spaceOrigin[k] * to_lps[k];
  } else if (nrrdOriginCalculate(&nrrd, indices.data(), count, nrrdCenterCell, origin.data()) ==
             nrrdOriginStatusOkay) {
    for (int k = 0; k < int(count); ++k) grid.origin[k] = origin[std::size_t(k)];
  }
  check_lattice(grid, path.string());
  return grid;
}

void take_role(NrrdLayout& layout, Role role, int size, std::uint64_t stride,
               const std::filesystem::path& path) {
  int& count = role == Role::frames ? layout.frames : layout.channels;
  if (count > 1)
    fail(path, role == Role::frames ? "it has two axes of volumes" : "it has two axes of components");
  count = size;
  (role == Role::frames ? layout.frame_stride : layout.channel_stride) = stride;
}

}  // namespace

Grid nrrd_grid(const Nrrd& nrrd, const std::filesystem::path& path) {
  return grid_of(nrrd, lattice_axes(nrrd), path);
}

std::optional<NrrdLayout> nrrd_layout(const Nrrd& nrrd, const std::filesystem::path& path) {
  const auto axes = lattice_axes(nrrd);
  if (axes.size() == nrrd.dim) return {};
  if (axes.empty() || axes.front() > 1) fail(path, "its first axes are not the lattice's");
  if (axes.back() - axes.front() + 1 != axes.size()) fail(path, "an axis lies between those of the lattice");
  NrrdLayout layout;
  layout.grid = grid_of(nrrd, axes, path);
  if (axes.front() == 1) {
    const auto& info = nrrd.axis[0];
    layout.leading = int(info.size);
    layout.leading_is = role_of(nrrd, 0);
    layout.colours = is_colour(info.kind) ||
                     (info.kind == nrrdKindUnknown && are_colours(layout.grid.type, layout.leading));
    if (layout.leading > 1) take_role(layout, layout.leading_is, layout.leading, 0, path);
  }
  for (unsigned axis = axes.back() + 1; axis < nrrd.dim; ++axis) {
    const auto size = nrrd.axis[axis].size;
    if (size > 1) take_role(layout, role_of(nrrd, axis), int(size), layout.volumes, path);
    if (layout.volumes > std::uint64_t(std::numeric_limits<std::int64_t>::max()) / size)
      fail(path, "its sizes overflow 64 bits");
    layout.volumes *= size;
  }
  return layout;
}

}  // namespace ringsplat::detail
