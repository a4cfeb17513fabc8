#pragma once
// Small HDF5 files, written by HDF5 itself.
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "decode/hdf5/library.hpp"
#include "formats/files.hpp"

namespace files {

using detail::hdf5::Id;

/// A dataset to write.
struct Hdf5 {
  std::string name = "/volume";
  std::vector<hsize_t> dims{nz, ny, nx};
  hid_t type = H5T_STD_I16LE;       ///< in the file
  hid_t memory = H5T_NATIVE_INT16;  ///< of `voxels`
  std::string voxels = samples<short>();
  std::vector<hsize_t> chunk = {};
  std::function<void(hid_t)> creation = [](hid_t) {};  ///< more properties: layout, filters
  std::function<void(hid_t)> attributes = [](hid_t) {};
};

inline Id opened(hid_t file, const std::string& name) { return Id(H5Oopen(file, name.c_str(), H5P_DEFAULT)); }

inline void add(hid_t file, const Hdf5& dataset) {
  const Id space(H5Screate_simple(int(dataset.dims.size()), dataset.dims.data(), nullptr)),
      creation(H5Pcreate(H5P_DATASET_CREATE)), links(H5Pcreate(H5P_LINK_CREATE));
  H5Pset_create_intermediate_group(links.get(), 1);
  H5Pset_obj_track_times(creation.get(), false);
  if (!dataset.chunk.empty()) H5Pset_chunk(creation.get(), int(dataset.chunk.size()), dataset.chunk.data());
  dataset.creation(creation.get());
  const Id made(H5Dcreate2(file, dataset.name.c_str(), dataset.type, space.get(), links.get(), creation.get(),
                           H5P_DEFAULT));
  if (!dataset.voxels.empty())
    H5Dwrite(made.get(), dataset.memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, dataset.voxels.data());
  dataset.attributes(made.get());
}

inline void put_text(hid_t object, const char* name, const std::string& text) {
  const Id type(H5Tcopy(H5T_C_S1)), space(H5Screate(H5S_SCALAR));
  H5Tset_size(type.get(), text.size() + 1);
  const Id made(H5Acreate2(object, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT));
  H5Awrite(made.get(), type.get(), text.c_str());
}

inline void put_numbers(hid_t object, const char* name, const std::vector<double>& numbers) {
  const hsize_t count = numbers.size();
  const Id space(H5Screate_simple(1, &count, nullptr));
  const Id made(H5Acreate2(object, name, H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT));
  H5Awrite(made.get(), H5T_NATIVE_DOUBLE, numbers.data());
}

/// Attaches coordinates to a dataset's dimensions, as netCDF-4 does: one variable for each name.
inline void put_scales(hid_t file, const std::string& dataset, const std::vector<std::string>& names) {
  const Id of(opened(file, dataset)), type(H5Tvlen_create(H5T_STD_REF_OBJ));
  const hsize_t count = names.size();
  const Id space(H5Screate_simple(1, &count, nullptr));
  std::vector<hobj_ref_t> references(names.size());
  std::vector<hvl_t> lists;
  for (std::size_t k = 0; k < names.size(); ++k) {
    H5Rcreate(&references[k], file, names[k].c_str(), H5R_OBJECT, -1);
    lists.push_back({1, &references[k]});
  }
  const Id made(H5Acreate2(of.get(), "DIMENSION_LIST", type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT));
  H5Awrite(made.get(), type.get(), lists.data());
}

/// A variable of coordinates.
inline Hdf5 axis(const std::string& name, const std::vector<double>& at, const std::string& unit) {
  Hdf5 made{.name = name, .dims = {at.size()}, .type = H5T_IEEE_F64LE, .memory = H5T_NATIVE_DOUBLE};
  made.voxels.assign(reinterpret_cast<const char*>(at.data()), at.size() * sizeof(double));
  made.attributes = [unit](hid_t id) { put_text(id, "units", unit); };
  return made;
}

/// Writes a file by what `fill` does to it. In the format of before HDF5 1.8, as most programs do, or the
/// newest.
inline fs::path write_hdf5(const fs::path& path, const std::function<void(hid_t)>& fill,
                           bool newest = false) {
  const Id access(H5Pcreate(H5P_FILE_ACCESS));
  if (newest) H5Pset_libver_bounds(access.get(), H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  const Id file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()));
  fill(file.get());
  return path;
}

inline fs::path write_hdf5(const fs::path& path, const std::vector<Hdf5>& datasets, bool newest = false) {
  return write_hdf5(
      path,
      [&](hid_t file) {
        for (const auto& dataset : datasets) add(file, dataset);
      },
      newest);
}

}  // namespace files
