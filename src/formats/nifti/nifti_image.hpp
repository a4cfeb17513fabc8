#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "formats/stored_source.hpp"
#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// What a NIfTI header says. Volumes of time points follow each other, those of a further vector component
/// follow all time points of the one before.
struct NiftiImage {
  Grid grid;            ///< of one volume, in millimetres; its type is the stored one
  StoredVoxels stored;  ///< the first volume
  int frames = 1;       ///< along axis 4
  int vectors = 1;      ///< along axes 5 to 7
  int colours = 1;      ///< numbers in a voxel: 3 of RGB24, 4 of RGBA32
};

struct NiftiType {
  ScalarType type = ScalarType::uint8;
  int colours = 1;
};

/// Of a datatype's code. Throws InputError for those that cannot be rendered, naming it `name`.
NiftiType nifti_type(int code, const std::string& name, const std::filesystem::path& path);

/// Columns: where a step along x, y, z leads, and where voxel 0 is; in the header's unit, right, anterior,
/// superior. Sheared where the header says so.
using NiftiAffine = std::array<glm::dvec3, 4>;
/// Gives the grid its spacing, origin and direction. Throws InputError when a step leads nowhere.
void place_nifti(const NiftiAffine& affine, int xyzt_units, const std::filesystem::path& path, Grid& grid);

/// Of the header's unit of length; 1 when it names none.
double nifti_millimetres(int xyzt_units);

/// NIfTI-1 standard, "scl_slope and scl_inter": a slope of 0 means that the values are as stored.
std::optional<Rescale> nifti_rescale(double slope, double intercept);

/// The file's NIfTI-2 header (540 bytes, nifti2.h); nothing when it begins otherwise. Of .nii, .nii.gz and
/// .hdr, whose voxels are in the .img or .img.gz beside it. Throws InputError when the header is damaged.
std::optional<NiftiImage> read_nifti2(const std::filesystem::path& path);

}  // namespace ringsplat::detail
