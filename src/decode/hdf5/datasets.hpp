#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "decode/hdf5/library.hpp"
#include "formats/axes.hpp"
#include "ringsplat/formats/open.hpp"

/// Which datasets a file holds, how their values are stored, and what its conventions say of their axes.
namespace ringsplat::detail::hdf5 {

/// How a dataset's numbers become voxels.
struct ValueType {
  ScalarType type = ScalarType::uint8;  ///< of the voxels
  bool wide = false;                    ///< stored as 64-bit integers, read as float64 where that is exact
  bool labels = false;                  ///< stored as an enumeration or a truth value
  std::string name = {};                ///< as stored: "uint16", "float16", "bool"
};

/// Nothing for texts, compounds, references and other types that are no numbers.
std::optional<ValueType> value_type_of(hid_t type);

/// A dataset's dimensions, the slowest first; empty for none, and for such that no volume has.
std::vector<int> dims_of(hid_t dataset);

/// A dataset or group by its path. Throws InputError when a link leads to another file or the path to
/// nothing.
Id open_object(hid_t file, const std::string& path, const std::string& where);

/// One time point of a file that keeps each in a group of its own.
struct Iterations {
  int count = 1;
  std::string group = "/";  ///< of the chosen one
};

/// Finds the dataset to read: `named` from the root (or, in openPMD files, from the chosen iteration), the
/// only one within a named group, or the only one of the file. `iterations` becomes the file's. Throws
/// InputError that lists the datasets when there are several.
std::string choose_dataset(hid_t file, const std::filesystem::path& path, const std::string& named,
                           const VolumeChoice& choice, Iterations& iterations);

// The conventions, each of which does nothing to a file of another.
void describe_vtkhdf(hid_t file, const std::string& path, const std::string& where, DatasetMeaning& meaning);
void describe_openpmd(hid_t file, hid_t dataset, const std::string& path, const std::string& where,
                      DatasetMeaning& meaning);
void describe_netcdf(hid_t dataset, const std::string& where, DatasetMeaning& meaning);
void describe_minc(hid_t file, hid_t dataset, const std::string& path, const std::string& where,
                   DatasetMeaning& meaning);
void describe_microscopy(hid_t dataset, DatasetMeaning& meaning);

}  // namespace ringsplat::detail::hdf5
