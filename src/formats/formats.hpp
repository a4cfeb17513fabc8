#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "ringsplat/formats/open.hpp"

/// One function a format; each throws InputError naming the file. `path` exists. A function of a format that
/// can hold several volumes takes the chosen one and throws InputError when there is none such; open_volume()
/// refuses other choices.
namespace ringsplat::detail {

std::unique_ptr<VolumeSource> open_nrrd(const std::filesystem::path& path, const VolumeChoice& choice);
std::unique_ptr<VolumeSource> open_meta(const std::filesystem::path& path, const VolumeChoice& choice);
std::unique_ptr<VolumeSource> open_nifti(const std::filesystem::path& path, const VolumeChoice& choice);
std::unique_ptr<VolumeSource> open_vtk(const std::filesystem::path& path, const VolumeChoice& choice);
std::unique_ptr<VolumeSource> open_vti(const std::filesystem::path& path, const VolumeChoice& choice);
/// Throws: the pieces of a parallel VTK file are files of their own.
std::unique_ptr<VolumeSource> refuse_pvti(const std::filesystem::path& path, const VolumeChoice& choice);
/// NumPy arrays: [z][y][x], in C order also with an axis of frames before and one of 1 to 4 components
/// behind.
std::unique_ptr<VolumeSource> open_npy(const std::filesystem::path& path, const VolumeChoice& choice);
/// Throws: an archive holds arrays by name.
std::unique_ptr<VolumeSource> refuse_npz(const std::filesystem::path& path, const VolumeChoice& choice);
std::unique_ptr<VolumeSource> open_tiff(const std::filesystem::path& path,
                                        const VolumeChoice& choice);  ///< one file or a folder
/// Opens a folder's series, or the series of one file.
std::unique_ptr<VolumeSource> open_dicom(const std::filesystem::path& path, const VolumeChoice& choice);
std::unique_ptr<VolumeSource> open_raw(const std::filesystem::path& path, const RawDescription& raw);

/// An HDF5 file (also netCDF-4, VTKHDF, openPMD), or a dataset in one: "file.h5:/path/to/dataset".
std::unique_ptr<VolumeSource> open_hdf5(const std::filesystem::path& path, const VolumeChoice& choice);
/// By its signature, whatever its ending. Throws InputError when it cannot be read.
bool is_hdf5(const std::filesystem::path& path);
/// A file and what follows the colon behind its name. A path that exists as a whole has nothing behind.
std::pair<std::filesystem::path, std::string> split_dataset(const std::filesystem::path& path);

/// Throws InputError that says what a folder holds instead of DICOM or TIFF images.
[[noreturn]] void refuse_without_images(const std::filesystem::path& folder);

bool is_tiff(const std::filesystem::path& path);

}  // namespace ringsplat::detail
