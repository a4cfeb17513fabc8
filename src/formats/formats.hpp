#pragma once
#include <filesystem>
#include <memory>
#include <optional>

#include "ringsplat/formats/open.hpp"

/// One function a format; each throws InputError naming the file. `path` exists. A function of a format that
/// can hold several volumes takes the chosen one and throws InputError when there is none such; open_volume()
/// refuses other choices.
namespace ringsplat::detail {

using Open = std::unique_ptr<VolumeSource>(const std::filesystem::path& path, const VolumeChoice& choice);

Open open_nrrd, open_meta, open_nifti, open_vtk, open_vti;
/// NumPy arrays: [z][y][x], in C order also with an axis of frames before and one of 1 to 4 components
/// behind.
Open open_npy;
/// Throws: an archive holds arrays by name.
Open refuse_npz;
/// MRC2014 and CCP4 maps, compressed by gzip, too.
Open open_mrc;
/// FreeSurfer's volumes, compressed by gzip or not.
Open open_mgh;
/// The first image of at least three axes in a FITS file; also compressed by gzip, but not in tiles.
Open open_fits;
/// A folder of Zarr, OME-Zarr or N5: an array, an image, whose finest level it opens, or a group that holds
/// one of these.
Open open_zarr;
/// A folder of AMReX, a plotfile, of which it opens level 0.
Open open_amrex;
std::unique_ptr<VolumeSource> open_raw(const std::filesystem::path& path, const RawDescription& raw);

// By ringsplat-decode, or, where that finds the voxels as they are in the file, by this process. They throw
// InputError also when the library crashes, takes too much time or memory.
Open open_hdf5, open_tiff, open_dicom;

/// MetaImage's names of types, in ScalarType's order.
inline constexpr const char* meta_types[] = {"MET_CHAR", "MET_UCHAR", "MET_SHORT", "MET_USHORT",
                                             "MET_INT",  "MET_UINT",  "MET_FLOAT", "MET_DOUBLE"};

/// Parses a name like NAME_256x256x128_uint8.raw (the convention of the Open SciVis data sets); nothing when
/// it has no such tag. Throws InputError for an unknown type or a size beyond int.
std::optional<Grid> parse_raw_name(const std::filesystem::path& path);

/// Throws InputError that says what a folder holds instead of DICOM, TIFF or PNG images.
[[noreturn]] void refuse_without_images(const std::filesystem::path& folder);

}  // namespace ringsplat::detail
