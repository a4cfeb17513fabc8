#include "formats/axes.hpp"

#include "base/log.hpp"
#include "formats/limits.hpp"

namespace ringsplat::detail {
namespace {

using Role = DatasetAxis::Role;

int count(const std::vector<DatasetAxis>& axes, Role role) {
  return int(std::count_if(axes.begin(), axes.end(), [&](const auto& axis) { return axis.role == role; }));
}

bool spare(const std::vector<DatasetAxis>& axes) { return count(axes, Role::space) > 3; }

std::string sizes_of(const std::vector<DatasetAxis>& axes) { return joined(axes, " x ", &DatasetAxis::size); }

/// The lattice's directions in the world: where every axis of space has its own they are taken, else the axes
/// lie along x, y, z in turn.
std::array<int, 3> world_axes(const std::array<int, 3>& lattice, const std::vector<DatasetAxis>& axes) {
  std::array<int, 3> world{};
  std::vector<int> left{0, 1, 2};
  for (std::size_t k = 0; k < 3; ++k) {
    const int axis = lattice[k];  // those below 0 come last
    const auto along = axis < 0 ? left.front() : axes[std::size_t(axis)].world.value_or(-1);
    if (std::erase(left, along) == 0) return {0, 1, 2};
    world[k] = along;
  }
  return world;
}

}  // namespace

std::optional<double> micrometres_in(const std::string& unit) {
  constexpr std::pair<const char*, double> units[] = {
      {"um \xC2\xB5m \xCE\xBCm \xB5m \\u00B5m \\u00b5m micron microns micrometer micrometre", 1},
      {"pm picometer", 1e-6},
      {"\xC3\x85 \xE2\x84\xAB angstrom", 1e-4},
      {"nm nanometer", 1e-3},
      {"mm millimeter", 1e3},
      {"cm centimeter", 1e4},
      {"dm decimeter", 1e5},
      {"m meter", 1e6},
      {"km kilometer", 1e9},
      {"in inch", 25400}};
  for (const auto& [names, size] : units)
    for (const auto& name : words_of(names))
      if (name == unit) return size;
  return {};
}

void describe_by_name(DatasetAxis& axis) {
  const auto is_one_of = [&](const char* names) {
    return std::ranges::count(words_of(names), axis.name) > 0;
  };
  constexpr const char* along[] = {"x lon longitude easting", "y lat latitude northing",
                                   "z height altitude alt lev level depth plev"};
  for (int world = 0; world < 3; ++world)
    if (is_one_of(along[world])) axis.known = true, axis.world = world;
  if (is_one_of("t time frame frames step")) axis.known = true, axis.role = Role::frame;
  if (is_one_of("c ch channel channels component components rgb rgba band"))
    axis.known = true, axis.role = Role::channel;
}

void settle_roles(DatasetMeaning& meaning, const std::string& where, const char* hint) {
  // Of more than three dimensions those of size 1 do not count, a last one of two to four is components, and
  // the first is time.
  auto& axes = meaning.axes;
  for (auto& axis : axes)
    if (spare(axes) && !axis.known && axis.size == 1) axis.role = Role::single;
  auto& last = axes.back();
  const bool components = last.size >= 2 && last.size <= 4;
  if (spare(axes) && !last.known && components && count(axes, Role::channel) == 0) last.role = Role::channel;
  const auto first = std::ranges::find_if(axes, [](const auto& axis) { return axis.role == Role::space; });
  if (spare(axes) && !first->known && count(axes, Role::frame) == 0) first->role = Role::frame;
  if (spare(axes) || count(axes, Role::frame) > 1 || count(axes, Role::channel) > 1)
    refuse(where, hint, "which of its dimensions, {}, are z, y and x cannot be told", sizes_of(axes));
  if (count(axes, Role::space) == 0)
    refuse(where, "name a dataset of three dimensions", "none of its dimensions, {}, is one of space",
           sizes_of(axes));
  for (const auto& axis : axes) {
    if (axis.role == Role::frame) meaning.notes.frames = axis.size;
    if (axis.role == Role::channel) meaning.notes.channels = axis.size;
  }
}

Grid lattice_of(const DatasetMeaning& meaning, const std::string& where) {
  const auto lattice = lattice_axes(meaning.axes);
  const auto world = world_axes(lattice, meaning.axes);
  Grid grid;
  grid.dims = glm::ivec3(1);
  grid.direction = glm::dmat3(0);
  for (int k = 0; k < 3; ++k) {
    const int number = lattice[std::size_t(k)], along = world[std::size_t(k)];
    const DatasetAxis axis = number < 0 ? DatasetAxis{} : meaning.axes[std::size_t(number)];
    grid.dims[k] = axis.size;
    grid.spacing[k] = axis.spacing;
    grid.direction[k][along] = axis.sign;
    grid.origin[along] = axis.first;
  }
  if (meaning.direction) grid.direction = *meaning.direction;
  if (meaning.origin) grid.origin = *meaning.origin;
  if (meaning.notes.world == World::microscope && !meaning.direction) {
    grid.direction = microscope_axes * grid.direction;
    grid.origin = microscope_axes * grid.origin;
  }
  check_lattice(grid, where);
  return grid;
}

ArrayPart choose_part(const DatasetMeaning& meaning, ScalarType type, const VolumeChoice& choice,
                      const std::string& where) {
  ArrayPart part;
  part.lattice = lattice_axes(meaning.axes);
  for (const auto& axis : meaning.axes) {
    if (axis.role != Role::channel) continue;
    const bool last = &axis == &meaning.axes.back();
    if (!meaning.notes.of_channels.empty())
      part.channel = int(choose_named_channel(choice.channel, axis.size, meaning.notes.of_channels, where));
    else if (last || !choice.channel.empty())
      part.channel = choose_channel(choice.channel, axis.size, last && are_colours(type, axis.size), where);
    else
      log_warning_once("{}: it has {} channels, the first is shown; --channel N shows another, all draws all",
                       where, axis.size);
    if (!part.channel) part.components = axis.size;
  }
  part.frame = chosen_frame(choice, meaning.notes.frames, where);
  for (const auto& axis : meaning.axes) {
    const bool is_channel = axis.role == Role::channel;
    const bool whole = axis.role == Role::space || (is_channel && !part.channel);
    const int other = is_channel ? part.channel.value_or(0) : 0;
    part.first.push_back(axis.role == Role::frame ? part.frame : other);
    part.end.push_back(whole ? axis.size : part.first.back() + 1);
  }
  return part;
}

}  // namespace ringsplat::detail
