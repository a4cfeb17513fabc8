// netCDF's dimensions and CF's attributes (CF conventions 1.11, chapters 2 to 5 and 8), dimension labels of
// HDF5's scales, and what ilastik and ImageJ's HDF5 plugins write.

#include <algorithm>
#include <cmath>
#include <set>

#include "base/log.hpp"
#include "base/printable.hpp"
#include "base/text.hpp"
#include "decode/hdf5/datasets.hpp"

namespace ringsplat::detail::hdf5 {
namespace {

using Role = DatasetAxis::Role;

std::string ascii(const std::string& text) {
  std::string kept;
  for (const char c : text) kept += c >= ' ' && c <= '~' ? c : '?';
  constexpr std::size_t longest = 80;
  return kept.substr(0, longest);
}

std::string last_part(hid_t object) {
  std::string name(256, '\0');
  const auto length = H5Iget_name(object, name.data(), name.size());
  if (length <= 0) return {};
  name.resize(std::min<std::size_t>(name.size() - 1, std::size_t(length)));
  return lower_case(name.substr(name.rfind('/') + 1));
}

/// The coordinates along an axis; empty for a dimension without a variable of its own.
std::vector<double> coordinates_of(hid_t scale, int size) {
  if (text_of(scale, "NAME").value_or("").rfind("This is a netCDF dimension but not", 0) == 0) return {};
  auto values = numbers_in(scale);
  return values.size() == std::size_t(size) ? values : std::vector<double>{};
}

/// Spacing and place of a regular axis; of another one the mean spacing, of which a warning tells.
void place(DatasetAxis& axis, const std::vector<double>& at, const std::string& where) {
  if (at.empty() || !std::isfinite(at.front())) return;
  axis.first = at.front();
  if (at.size() < 2) return;
  const double step = (at.back() - at.front()) / double(at.size() - 1);
  if (!std::isfinite(step) || step == 0) return;
  constexpr double tolerance = 1e-4;
  for (std::size_t i = 1; i < at.size(); ++i)
    if (!(std::abs(at[i] - at[i - 1] - step) <= tolerance * std::abs(step))) {
      log_warning_once(
          "{}: the coordinates along {} are not evenly spaced; drawn as if they were, {:g} apart, their mean",
          where, printable(axis.name), std::abs(step));
      break;
    }
  axis.spacing = std::abs(step);
  axis.sign = step < 0 ? -1 : 1;
}

bool is_pressure(const std::string& unit) {
  static const std::set<std::string> units{"pa", "hpa", "mbar", "millibar", "millibars", "bar", "mb"};
  return units.count(lower_case(unit)) != 0;
}

void describe_coordinates(hid_t scale, DatasetAxis& axis) {
  axis.unit = ascii(text_of(scale, "units").value_or(""));
  const auto is = [&](const char* attribute, std::initializer_list<const char*> values) {
    const auto text = lower_case(text_of(scale, attribute).value_or(""));
    return std::find(values.begin(), values.end(), text) != values.end();
  };
  const auto along = [&](int world) { axis.world = world, axis.known = true, axis.role = Role::space; };
  if (is("axis", {"x"}) || is("standard_name", {"longitude", "projection_x_coordinate"}) ||
      axis.unit.rfind("degrees_east", 0) == 0)
    along(0);
  if (is("axis", {"y"}) || is("standard_name", {"latitude", "projection_y_coordinate"}) ||
      axis.unit.rfind("degrees_north", 0) == 0)
    along(1);
  if (is("axis", {"z"}) || is("positive", {"up", "down"}) || is_pressure(axis.unit)) along(2);
  if (is("axis", {"t"}) || is("standard_name", {"time"}) || axis.unit.find(" since ") != std::string::npos)
    axis.known = true, axis.role = Role::frame;
  if (axis.role == Role::frame) axis.spacing = 1;
}

void describe_axis(hid_t scale, DatasetAxis& axis, const std::string& where) {
  axis.name = last_part(scale);
  describe_by_name(axis);
  describe_coordinates(scale, axis);
  if (axis.role != Role::space) return;
  place(axis, coordinates_of(scale, axis.size), where);
  const auto positive = lower_case(text_of(scale, "positive").value_or(""));
  const bool down = positive == "down" || (positive.empty() && is_pressure(axis.unit));
  if (!down) return;
  axis.sign = -axis.sign;
  axis.first = -axis.first;
}

/// One unit for all axes. Heights in metres beside degrees have no spacing that can be compared: the odd axis
/// gets that of the others.
void settle_units(DatasetMeaning& meaning, const std::string& where) {
  std::vector<DatasetAxis*> space;
  for (auto& axis : meaning.axes) {
    if (axis.unit.rfind("degree", 0) == 0) axis.unit = "degrees";
    if (axis.role == Role::space && axis.size > 1) space.push_back(&axis);
  }
  if (space.empty()) return;
  const std::string unit = space.back()->unit;
  meaning.notes.unit = unit;
  for (auto* axis : space) {
    if (axis->unit == unit) continue;
    log_warning_once("{}: {} is in {}, {} in {}: drawn with the same distance between voxels", where,
                     printable(axis->name), axis->unit.empty() ? "no unit" : axis->unit,
                     printable(space.back()->name), unit.empty() ? "no unit" : unit);
    axis->first *= space.back()->spacing / axis->spacing;
    axis->spacing = space.back()->spacing;
  }
}

void describe_values(hid_t dataset, DatasetMeaning& meaning) {
  const double scale = number_of(dataset, "scale_factor").value_or(1),
               offset = number_of(dataset, "add_offset").value_or(0);
  if (std::isfinite(scale) && std::isfinite(offset) && scale != 0 && (scale != 1 || offset != 0))
    meaning.rescale = {{scale, offset}};
  for (const char* name : {"missing_value", "_FillValue"})
    if (const auto fill = number_of(dataset, name); fill && std::isfinite(*fill)) meaning.notes.fill = *fill;
  auto quantity = text_of(dataset, "long_name").value_or("");
  if (quantity.empty()) quantity = text_of(dataset, "standard_name").value_or("");
  if (quantity.empty()) return;
  const auto unit = text_of(dataset, "units").value_or("");
  meaning.notes.quantity = ascii(unit.empty() || unit == "1" ? quantity : quantity + " (" + unit + ")");
}

}  // namespace

void describe_netcdf(hid_t dataset, const std::string& where, DatasetMeaning& meaning) {
  describe_values(dataset, meaning);
  const auto labels = texts_of(dataset, "DIMENSION_LABELS");
  for (std::size_t k = 0; k < labels.size() && labels.size() == meaning.axes.size(); ++k)
    if (!labels[k].empty()) {
      meaning.axes[k].name = lower_case(labels[k]);
      describe_by_name(meaning.axes[k]);
    }
  const auto scales = scales_of(dataset, int(meaning.axes.size()));
  for (std::size_t k = 0; k < scales.size(); ++k)
    if (scales[k]) describe_axis(scales[k].get(), meaning.axes[k], where);
  if (!scales.empty()) settle_units(meaning, where);
}

void describe_microscopy(hid_t dataset, DatasetMeaning& meaning) {
  // ilastik: {"axes": [{"key": "t", ...}, ...]}, one key an axis in the order of the dimensions.
  const auto tags = text_of(dataset, "axistags").value_or("");
  std::string keys;
  constexpr std::string_view before = "\"key\": \"";
  for (auto at = tags.find(before); at != std::string::npos; at = tags.find(before, at + 1))
    if (at + before.size() < tags.size()) keys += tags[at + before.size()];
  for (std::size_t k = 0; k < keys.size() && keys.size() == meaning.axes.size(); ++k) {
    meaning.axes[k].name = std::string(1, keys[k]);
    describe_by_name(meaning.axes[k]);
    // Names of a picture's axes: the lattice stays as it is.
    meaning.axes[k].world.reset();
    meaning.notes.world = World::microscope;
  }
  // ImageJ and ilastik: micrometres along z, y, x.
  const auto sizes = numbers_of(dataset, "element_size_um");
  const bool sound = std::all_of(sizes.begin(), sizes.end(), [](double s) { return s > 0 && s < 1e12; });
  if (sizes.size() != 3 || !sound || meaning.axes.size() < 3) return;
  meaning.notes.world = World::microscope;
  meaning.notes.unit = "um";
  std::size_t k = 3;
  const bool interleaved =
      meaning.axes.size() > 3 && !meaning.axes.back().known && meaning.axes.back().size <= 4;
  for (std::size_t axis = meaning.axes.size() - (interleaved ? 1 : 0); axis > 0 && k > 0; --axis)
    if (meaning.axes[axis - 1].role == Role::space) meaning.axes[axis - 1].spacing = sizes[--k];
}

}  // namespace ringsplat::detail::hdf5
