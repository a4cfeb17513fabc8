// Simulations' own conventions: VTKHDF's ImageData (VTK's file formats, "VTKHDF") and openPMD's mesh records
// (openPMD standard 1.1, "Mesh Based Records").
#include <algorithm>
#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>

#include "base/printable.hpp"
#include "base/text.hpp"
#include "decode/hdf5/datasets.hpp"
#include "formats/limits.hpp"

namespace ringsplat::detail::hdf5 {
namespace {

using Role = DatasetAxis::Role;

Id opened(hid_t file, const std::string& path) { return Id(H5Oopen(file, path.c_str(), H5P_DEFAULT)); }

glm::dvec3 vector_of(const std::vector<double>& numbers, const glm::dvec3& otherwise) {
  return numbers.size() < 3 ? otherwise : glm::make_vec3(numbers.data());
}

/// Points or cells of the extent along x, y, z.
std::array<int, 3> extent_sizes(const std::vector<double>& extent, bool cells) {
  std::array<int, 3> sizes{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double steps = extent[2 * k + 1] - extent[2 * k];
    constexpr double most = 1 << 30;
    if (!(steps >= 0 && steps < most)) return {};
    sizes[k] = int(cells ? std::max(steps, 1.0) : steps + 1);
  }
  return sizes;
}

/// Of dimensions with z, y, x of these sizes. Without a time dimension, one of time, each with or without
/// components behind.
bool set_roles(std::vector<DatasetAxis>& axes, const std::array<int, 3>& sizes, bool temporal) {
  for (const std::size_t first : {std::size_t(temporal), std::size_t(!temporal)}) {
    if (axes.size() < first + 3 || axes.size() > first + 4) continue;
    if (axes[first].size != sizes[2] || axes[first + 1].size != sizes[1] || axes[first + 2].size != sizes[0])
      continue;
    for (std::size_t k = 0; k < axes.size(); ++k) {
      axes[k].known = true;
      axes[k].role = k < first ? Role::frame : k < first + 3 ? Role::space : Role::channel;
      if (axes[k].role != Role::space && axes[k].size == 1) axes[k].role = Role::single;
    }
    return true;
  }
  return false;
}

}  // namespace

void describe_vtkhdf(hid_t file, const std::string& path, const std::string& where, DatasetMeaning& meaning) {
  const bool points = path.rfind("/VTKHDF/PointData/", 0) == 0,
             cells = path.rfind("/VTKHDF/CellData/", 0) == 0;
  if (!points && !cells) return;
  const Id root = opened(file, "/VTKHDF");
  if (!root) return;
  const auto type = text_of(root.get(), "Type").value_or("");
  if (type != "ImageData")
    refuse(where, "only ImageData is a regular volume: resample it to an image first",
           "a VTKHDF file of type {}", excerpt(type));
  const auto extent = numbers_of(root.get(), "WholeExtent");
  if (extent.size() != 6)
    refuse(where, "write the file again", "VTKHDF's attribute WholeExtent has no 6 numbers");
  const Id steps = H5Lexists(root.get(), "Steps", H5P_DEFAULT) > 0 ? opened(file, "/VTKHDF/Steps") : Id();
  if (!set_roles(meaning.axes, extent_sizes(extent, cells), bool(steps)))
    refuse(where, "write the file again",
           "its dimensions do not fit VTKHDF's WholeExtent {:g} {:g} {:g} {:g} {:g} {:g}", extent[0],
           extent[1], extent[2], extent[3], extent[4], extent[5]);
  const glm::dvec3 spacing = vector_of(numbers_of(root.get(), "Spacing"), glm::dvec3(1)),
                   first(extent[0], extent[2], extent[4]);
  glm::dmat3 direction(1);
  if (const auto rows = numbers_of(root.get(), "Direction"); rows.size() == 9)
    direction = glm::transpose(glm::make_mat3(rows.data()));
  const auto lattice = lattice_axes(meaning.axes);
  for (int k = 0; k < 3; ++k) meaning.axes[std::size_t(lattice[std::size_t(k)])].spacing = spacing[k];
  glm::dvec3 shift(0);
  for (int k = 0; cells && k < 3; ++k) shift[k] = extent[std::size_t(2 * k + 1)] > first[k] ? 0.5 : 0;
  meaning.direction = direction;
  meaning.origin =
      vector_of(numbers_of(root.get(), "Origin"), glm::dvec3(0)) + direction * (spacing * (first + shift));
}

void describe_openpmd(hid_t file, hid_t dataset, const std::string& path, const std::string& where,
                      DatasetMeaning& meaning) {
  const Id root = opened(file, "/");
  if (!root || !text_of(root.get(), "openPMD")) return;
  // A scalar record is the dataset; a vector's components lie in the record's group.
  const Id group = opened(file, path.substr(0, std::max<std::size_t>(1, path.rfind('/'))));
  const bool scalar = H5Aexists(dataset, "gridSpacing") > 0;
  if (!scalar && (!group || H5Aexists(group.get(), "gridSpacing") <= 0)) return;
  const hid_t record = scalar ? dataset : group.get();
  const auto geometry = text_of(record, "geometry").value_or("cartesian");
  if (geometry != "cartesian" && geometry.rfind("other", 0) != 0)
    refuse(where, "only cartesian meshes are regular volumes: resample it first",
           "an openPMD mesh in {} coordinates", excerpt(geometry));
  auto spacing = numbers_of(record, "gridSpacing"), offset = numbers_of(record, "gridGlobalOffset"),
       position = numbers_of(dataset, "position");
  auto labels = texts_of(record, "axisLabels");
  const std::size_t axes = meaning.axes.size();
  if (spacing.size() != axes) return;
  // Attributes are in the order of C or of Fortran; a dataset's dimensions always in that of C.
  if (text_of(record, "dataOrder").value_or("C") == "F") {
    for (auto* list : {&spacing, &offset, &position}) std::reverse(list->begin(), list->end());
    std::reverse(labels.begin(), labels.end());
  }
  const double si = number_of(record, "gridUnitSI").value_or(1);
  for (std::size_t k = 0; k < axes; ++k) {
    DatasetAxis& axis = meaning.axes[k];
    axis.known = true;
    if (k < labels.size()) axis.name = lower_case(labels[k]);
    describe_by_name(axis);
    axis.role = Role::space;
    axis.spacing = spacing[k] * si;
    const double inside = position.size() == axes ? position[k] : 0;
    axis.first = ((offset.size() == axes ? offset[k] : 0) + inside * spacing[k]) * si;
  }
  meaning.notes.unit = std::string("m");  // GCC 12 warns falsely of the text itself
  meaning.notes.quantity = path.substr(path.rfind('/') + 1);
}

}  // namespace ringsplat::detail::hdf5
