#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "formats/stored_source.hpp"
#include "ringsplat/formats/open.hpp"

/// One function a format that libraries read; each throws InputError naming the file. `path` exists.
namespace ringsplat::detail {

/// An HDF5 file (also netCDF-4, VTKHDF, openPMD), or a dataset in one: "file.h5:/path/to/dataset". `in_place`
/// becomes where the voxels lie in the file as they are, if they do.
std::unique_ptr<VolumeSource> read_hdf5(const std::filesystem::path& path, const VolumeChoice& choice,
                                        std::optional<StoredVoxels>& in_place);
/// One TIFF file, or a folder of them or of PNG files.
std::unique_ptr<VolumeSource> read_tiff(const std::filesystem::path& path, const VolumeChoice& choice);
/// A folder's series, or the series of one file.
std::unique_ptr<VolumeSource> read_dicom(const std::filesystem::path& path, const VolumeChoice& choice);

/// Gives this process ten more seconds of the processor's time and two more gigabytes of memory, and what
/// reading `bytes` may need of both. When the time is over the system ends it; more memory is not there.
/// Called whenever something was read, so that what comes to no end is ended, and nothing else.
void progress(std::uint64_t bytes = 0);

}  // namespace ringsplat::detail
