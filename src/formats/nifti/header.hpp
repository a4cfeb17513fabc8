#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat::detail {

/// What matters here of a NIfTI-1 header of 348 bytes (nifti1.h), a NIfTI-2 header of 540 (nifti2.h), or an
/// Analyze 7.5 header, which has NIfTI-1's first fields.
struct NiftiHeader {
  std::filesystem::path path;
  int version = 1;     ///< 0: Analyze
  bool single = true;  ///< the voxels are in the header's own file
  bool big_endian = false;
  std::array<std::int64_t, 8> dims{};  ///< of x, y, z, time and three more from 1 on; 1 for those it has not
  int datatype = 0;
  std::array<double, 4> spacing{};  ///< of x, y, z from 1 on; the first: less than 0 mirrors the qform's z
  std::int64_t offset = 0;          ///< of the voxels in their file
  double slope = 0, intercept = 0;
  int units = 0, qform = 0, sform = 0;
  std::array<double, 3> quaternion{}, shift{};
  std::array<std::array<double, 4>, 3> rows{};

  [[noreturn]] void fail(const std::string& what) const;
};

/// Of the file itself, or of the .hdr beside an .img or .img.gz. Throws InputError when there is none, and
/// for impossible dimensions and offsets.
NiftiHeader read_nifti_header(const std::filesystem::path& path);

/// Where the sform puts the voxels, sheared too; else the qform; else as the lattice's axes are the world's.
/// In millimetres, left, posterior, superior. Without the type. Throws InputError when a step leads nowhere.
Grid nifti_grid(const NiftiHeader& header);

bool is_gzip(const std::filesystem::path& path);

}  // namespace ringsplat::detail
