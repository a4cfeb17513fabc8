#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "decode/hdf5/library.hpp"
#include "formats/stored_source.hpp"
#include "ringsplat/volume/source.hpp"

/// What a dataset's axes mean, and how the file's conventions tell it.
namespace ringsplat::detail::hdf5 {

/// One axis of a dataset, in the order of its dimensions: the last is the fastest in memory.
struct DatasetAxis {
  enum class Role { space, frame, channel, single };
  int size = 1;
  Role role = Role::space;
  bool known = false;                       ///< a convention told the role
  std::string name = {};                    ///< in small letters; empty: unknown
  std::optional<int> world = std::nullopt;  ///< along x, y or z of the world
  double sign = 1;                          ///< -1: indices grow against the world's axis
  double spacing = 1, first = 0;            ///< of neighbours; world coordinate of index 0
  std::string unit = {};
};

/// A dataset as its conventions describe it.
struct DatasetMeaning {
  std::vector<DatasetAxis> axes;
  VolumeNotes notes;
  std::vector<Rescale> rescale = {};  ///< none, one for all, or one a slice, frame after frame
  /// Where a convention gives it instead of the axes' own positions.
  std::optional<glm::dvec3> origin = std::nullopt;
  std::optional<glm::dmat3> direction = std::nullopt;
};

/// The meaning of `dataset` at `path`: by VTKHDF, openPMD, netCDF's CF, h5py's labels, ilastik's and ImageJ's
/// attributes, MINC's; else the last three dimensions are z, y, x, and what is left over frames or
/// components. Warns of what is drawn otherwise than it is. Throws InputError for meshes that are not
/// rectilinear, sizes that contradict each other, and dimensions that cannot be told apart.
DatasetMeaning meaning_of(hid_t file, hid_t dataset, const std::string& path, const std::vector<int>& dims,
                          const std::string& where);

/// Numbers of the dimensions along x, y, z of the lattice; -1: the volume has one voxel along it.
std::array<int, 3> lattice_axes(const std::vector<DatasetAxis>& axes);

/// The volume's lattice; the type is left alone. Warns, with `where`, of units that differ.
Grid lattice_of(const DatasetMeaning& meaning, const std::string& where);

// The conventions, each of which does nothing to a file of another.
void describe_vtkhdf(hid_t file, const std::string& path, const std::string& where, DatasetMeaning& meaning);
void describe_openpmd(hid_t file, hid_t dataset, const std::string& path, const std::string& where,
                      DatasetMeaning& meaning);
void describe_netcdf(hid_t dataset, const std::string& where, DatasetMeaning& meaning);
void describe_minc(hid_t file, hid_t dataset, const std::string& path, const std::string& where,
                   DatasetMeaning& meaning);
void describe_microscopy(hid_t dataset, DatasetMeaning& meaning);
/// What an axis's name says of its role and direction.
void describe_by_name(DatasetAxis& axis);

}  // namespace ringsplat::detail::hdf5
