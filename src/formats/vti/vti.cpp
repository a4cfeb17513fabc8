#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/text_source.hpp"
#include "formats/vti/header.hpp"
#include "formats/vti/source.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::array<std::pair<std::string_view, ScalarType>, 8> types{{
    {"Int8", ScalarType::int8},
    {"UInt8", ScalarType::uint8},
    {"Int16", ScalarType::int16},
    {"UInt16", ScalarType::uint16},
    {"Int32", ScalarType::int32},
    {"UInt32", ScalarType::uint32},
    {"Float32", ScalarType::float32},
    {"Float64", ScalarType::float64},
}};

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what, const std::string& hint) {
  throw InputError(fmt::format("{}: {}", path.string(), what), hint);
}

struct Chosen {
  const VtiArray& array;
  std::string component;  ///< as --channel has it behind a colon; empty: not chosen
};

const VtiArray* array_named(const VtiHeader& header, std::string_view name) {
  for (const auto& array : header.arrays)
    if (array.name == name) return &array;
  return nullptr;
}

/// The active scalars, else the only array.
const VtiArray* default_array(const VtiHeader& header) {
  for (const bool of_cells : {false, true})
    for (const auto& array : header.arrays)
      if (array.of_cells == of_cells && !array.name.empty() &&
          array.name == (of_cells ? header.cell_scalars : header.point_scalars))
        return &array;
  return header.arrays.size() == 1 ? &header.arrays.front() : nullptr;
}

/// --channel is an array's name, a component of the default array, or both: NAME:COMPONENT.
Chosen choose(const VtiHeader& header, const std::string& channel, const std::filesystem::path& path) {
  const auto* array = channel.empty() ? nullptr : array_named(header, channel);
  if (array != nullptr) return {*array, {}};
  const auto colon = channel.rfind(':');
  if (colon != std::string::npos) {
    array = array_named(header, channel.substr(0, colon));
    if (array != nullptr) return {*array, channel.substr(colon + 1)};
  }
  array = default_array(header);
  const bool component = array != nullptr && (array->components > 1 || header.arrays.size() == 1);
  if (array != nullptr && (channel.empty() || component)) return {*array, channel};
  std::vector<std::string> names;
  for (const auto& each : header.arrays) names.push_back(excerpt(each.name));
  if (channel.empty())
    fail(path, fmt::format("it holds {} arrays", names.size()),
         "choose one with --channel: " + comma_list(names));
  fail(path, fmt::format("--channel {}: it has no such array", channel),
       "its arrays are " + comma_list(names));
}

ScalarType type_of(const VtiArray& array, const std::filesystem::path& path) {
  for (const auto& [name, type] : types)
    if (name == array.type) return type;
  fail(path,
       fmt::format("voxels of type '{}' cannot be rendered (the array '{}')", excerpt(array.type),
                   excerpt(array.name)),
       "convert them to Int32, UInt32 or Float32 first");
}

/// Points lie on the lattice, cells between; the lattice's point (0, 0, 0) is at the origin, wherever the
/// extent begins. A flat volume has one layer of cells.
Grid grid_of(const VtiHeader& header, const VtiArray& array, const std::filesystem::path& path) {
  Grid grid;
  glm::dvec3 first(0);
  for (int axis = 0; axis < 3; ++axis) {
    const auto cells = std::int64_t(header.last[axis]) - header.first[axis];
    const auto size = array.of_cells ? std::max<std::int64_t>(cells, cells == 0 ? 1 : 0) : cells + 1;
    if (size < 1 || size > std::numeric_limits<int>::max())
      fail(path,
           fmt::format("its extent is {} to {} along axis {}", header.first[axis], header.last[axis], axis),
           "the extent must hold a point");
    grid.dims[axis] = int(size);
    first[axis] = header.first[axis] + (array.of_cells && cells > 0 ? 0.5 : 0.0);
  }
  grid.spacing = header.spacing;
  grid.direction = header.direction;
  grid.origin = header.origin + header.direction * (header.spacing * first);
  grid.type = type_of(array, path);
  check_lattice(grid, path.string());
  return grid;
}

}  // namespace

std::unique_ptr<VolumeSource> open_vti(const std::filesystem::path& path, const VolumeChoice& choice) {
  auto header = read_vti_header(path);
  // What ParaView hides; not what somebody measured.
  std::erase_if(header.arrays, [](const VtiArray& array) { return array.name.starts_with("vtkGhost"); });
  if (header.arrays.empty())
    fail(path, "it holds no array of points or cells", "save the volume's scalars, too");
  const auto [array, component] = choose(header, choice.channel, path);
  const Grid grid = grid_of(header, array, path);
  const int components = array.components;
  const auto wide = interleaved_grid(grid, components, path.string());
  auto source = array.format == VtiFormat::ascii ? text_source(wide, path, array.begin, array.end)
                                                 : vti_source(wide, path, header, array);
  if (components > 1) {
    const auto taken = choose_channel(component, components, are_colours(grid.type, components),
                                      fmt::format("{}, array '{}'", path.string(), excerpt(array.name)));
    source = channel_source(std::move(source), grid, components, taken);
  }
  const auto channels = std::max<std::int64_t>(components, std::int64_t(header.arrays.size()));
  return with_notes(std::move(source), {.quantity = array.name, .channels = int(channels)});
}

std::unique_ptr<VolumeSource> refuse_pvti(const std::filesystem::path& path, const VolumeChoice&) {
  fail(path, "a .pvti names the files of several pieces",
       "write the volume into one .vti, or load it in ParaView and save it as one");
}

}  // namespace ringsplat::detail
