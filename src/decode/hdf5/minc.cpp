// MINC 2.0's conventions (MINC 2.0 file format reference): dimensions by name, each with its step, start and
// direction in the patient's world, and for every slice the real values of the ends of the stored range.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/log.hpp"
#include "base/printable.hpp"
#include "base/text.hpp"
#include "decode/hdf5/datasets.hpp"
#include "formats/limits.hpp"

namespace ringsplat::detail::hdf5 {
namespace {

using Role = DatasetAxis::Role;

/// The standard's axes point right, anterior and superior.
const glm::dvec3 to_lps(-1, -1, 1);

constexpr const char* hint = "convert it, for example with 'mnc2nii IN.mnc OUT.nii'";

/// Describes the dimension and returns its direction in the world.
glm::dvec3 describe_dimension(hid_t file, const std::string& where, DatasetAxis& axis) {
  axis.known = true;
  if (axis.name == "time" || axis.name == "tspace") axis.role = Role::frame;
  if (axis.name == "vector_dimension") axis.role = Role::channel;
  if (axis.role != Role::space) return {};
  const auto letter = std::string_view("xyz").find(axis.name.substr(0, 1));
  if (letter == std::string_view::npos || axis.name.substr(1) != "space")
    refuse(where, hint, "its dimension {} is none of space", excerpt(axis.name));
  axis.world = int(letter);
  const Id said = open_object(file, "/minc-2.0/dimensions/" + axis.name, where);
  const double step = number_of(said.get(), "step").value_or(1);
  axis.spacing = std::abs(step);
  axis.sign = step < 0 ? -1 : 1;
  axis.first = number_of(said.get(), "start").value_or(0);
  if (text_of(said.get(), "spacing").value_or("").starts_with("irregular"))
    log_warning_once("{}: {} is not evenly spaced; drawn as if it were, {:g} apart", where, axis.name,
                     axis.spacing);
  glm::dvec3 direction(0);
  direction[*axis.world] = 1;
  const auto cosines = numbers_of(said.get(), "direction_cosines");
  if (cosines.size() == 3) direction = {cosines[0], cosines[1], cosines[2]};
  return direction * to_lps;
}

/// Integers' valid range: the whole of their type where the file names none.
std::array<double, 2> valid_range_of(hid_t dataset, ScalarType type) {
  if (const auto said = numbers_of(dataset, "valid_range"); said.size() == 2 && said[0] != said[1])
    return {std::min(said[0], said[1]), std::max(said[0], said[1])};
  return visit_type(type, [](auto zero) -> std::array<double, 2> {
    using Limits = std::numeric_limits<decltype(zero)>;
    return {double(Limits::lowest()), double(Limits::max())};
  });
}

/// How far apart in image-min the values of neighbouring frames and slices are; 0 where it has one for all.
/// It has the image's first dimensions.
struct Strides {
  std::size_t frame = 0, slice = 0;
};

Strides strides_of(const std::vector<int>& dims, const std::vector<DatasetAxis>& axes,
                   const std::string& where) {
  const int slices = lattice_axes(axes)[2];
  Strides strides;
  std::size_t stride = 1;
  for (std::size_t k = std::min(dims.size(), axes.size()); k > 0; --k) {
    const auto& axis = axes[k - 1];
    const bool is_slice = int(k) - 1 == slices, sound = dims[k - 1] == axis.size;
    if (!sound || (axis.role != Role::frame && !is_slice && axis.size > 1))
      refuse(where, hint, "its values are not scaled slice by slice");
    if (is_slice) strides.slice = stride;
    if (axis.role == Role::frame) strides.frame = stride;
    stride *= std::size_t(axis.size);
  }
  return strides;
}

std::vector<Rescale> rescale_of(hid_t file, hid_t dataset, const std::string& path, const std::string& where,
                                const std::vector<DatasetAxis>& axes) {
  const Id type(H5Dget_type(dataset));
  const auto value = value_type_of(type.get());
  if (!value || H5Tget_class(type.get()) == H5T_FLOAT) return {};
  const std::string group = path.substr(0, path.rfind('/') + 1);
  if (H5Lexists(file, (group + "image-min").c_str(), H5P_DEFAULT) <= 0) return {};
  const Id low = open_object(file, group + "image-min", where),
           high = open_object(file, group + "image-max", where);
  const auto dims = dims_of(low.get());
  const auto strides = strides_of(dims, axes, where);
  const auto lows = numbers_in(low.get()), highs = numbers_in(high.get());
  std::size_t expected = 1;
  for (const int size : dims) expected *= std::size_t(size);
  if (lows.size() != expected || highs.size() != expected)
    refuse(where, hint, "its image-min and image-max cannot be read");
  const auto valid = valid_range_of(dataset, value->type);
  const auto made = [&](std::size_t at) {
    const double slope = (highs[at] - lows[at]) / (valid[1] - valid[0]);
    return Rescale{slope, lows[at] - slope * valid[0]};
  };
  const auto as_stored = [&](const Rescale& r) {
    constexpr double rounding = 1e-9;
    return std::abs(r.slope - 1) < rounding && std::abs(r.intercept) < rounding * (valid[1] - valid[0]);
  };
  if (strides.frame == 0 && strides.slice == 0)
    return as_stored(made(0)) ? std::vector<Rescale>{} : std::vector{made(0)};
  std::size_t frames = 1;
  for (const auto& axis : axes)
    if (axis.role == Role::frame) frames = std::size_t(axis.size);
  const auto slices = std::size_t(axes[std::size_t(lattice_axes(axes)[2])].size);
  std::vector<Rescale> all;
  for (std::size_t frame = 0; frame < frames; ++frame)
    for (std::size_t z = 0; z < slices; ++z) all.push_back(made(frame * strides.frame + z * strides.slice));
  return std::all_of(all.begin(), all.end(), as_stored) ? std::vector<Rescale>{} : all;
}

}  // namespace

void describe_minc(hid_t file, hid_t dataset, const std::string& path, const std::string& where,
                   DatasetMeaning& meaning) {
  if (!path.starts_with("/minc-2.0/image/") || !path.ends_with("/image")) return;
  auto order = text_of(dataset, "dimorder").value_or("");
  std::ranges::replace(order, ',', ' ');
  const auto names = words_of(order);
  auto& axes = meaning.axes;
  if (names.size() != axes.size())
    refuse(where, hint, "its dimorder does not name its {} dimensions", axes.size());
  std::vector<glm::dvec3> directions;
  glm::dvec3 origin(0);
  for (std::size_t k = 0; k < axes.size(); ++k) {
    axes[k].name = names[k];
    directions.push_back(describe_dimension(file, where, axes[k]));
    origin += directions[k] * axes[k].first;
  }
  const auto lattice = lattice_axes(axes);
  if (std::ranges::count(lattice, -1) > 0) refuse(where, hint, "it has no three dimensions of space");
  meaning.origin = origin;
  meaning.direction.emplace();
  for (int k = 0; k < 3; ++k) {
    const auto axis = std::size_t(lattice[std::size_t(k)]);
    (*meaning.direction)[k] = directions[axis] * axes[axis].sign;
  }
  meaning.rescale = rescale_of(file, dataset, path, where, axes);
  meaning.notes = {.world = World::patient, .unit = "mm"};
}

}  // namespace ringsplat::detail::hdf5
