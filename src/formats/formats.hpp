#pragma once
#include <filesystem>
#include <memory>

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
std::unique_ptr<VolumeSource> open_raw(const std::filesystem::path& path, const RawDescription& raw);

/// Throws InputError that says what a folder holds instead of DICOM or TIFF images.
[[noreturn]] void refuse_without_images(const std::filesystem::path& folder);

}  // namespace ringsplat::detail
