#pragma once
#include "formats/files.hpp"

namespace files {

/// A NIfTI-2 header of 540 bytes (nifti2.h) and its empty extension.
struct Nifti2 {
  std::int64_t dims[8] = {3, nx, ny, nz, 1, 1, 1, 1};
  short datatype = 4;
  double spacing[4] = {1, 1, 2, 3};  ///< the first: -1 mirrors z of the qform
  double slope = 0, intercept = 0;
  int qform = 0, sform = 1, units = 2;
  double quaternion[3] = {0, 0, 0}, shift[3] = {0, 0, 0};
  double rows[12] = {1, 0, 0, -10, 0, 2, 0, -20, 0, 0, 3, -30};  ///< voxel to RAS world
  const char* magic = "n+2";
  std::int64_t offset = 544;

  std::string header(bool big_endian = false) const {
    std::string h(544, '\0');
    const auto put = [&](std::size_t at, auto value) {
      const auto bytes = bytes_of(value, big_endian);
      std::copy(bytes.begin(), bytes.end(), h.begin() + std::ptrdiff_t(at));
    };
    const std::string signature = magic + std::string("\0\r\n\032\n", 5);
    put(0, std::int32_t(540));
    std::copy(signature.begin(), signature.end(), h.begin() + 4);
    put(12, datatype);
    for (std::size_t i = 0; i < 8; ++i) put(16 + 8 * i, dims[i]);
    for (std::size_t i = 0; i < 4; ++i) put(104 + 8 * i, spacing[i]);
    put(168, offset);
    put(176, slope);
    put(184, intercept);
    put(344, std::int32_t(qform));
    put(348, std::int32_t(sform));
    for (std::size_t i = 0; i < 3; ++i) put(352 + 8 * i, quaternion[i]);
    for (std::size_t i = 0; i < 3; ++i) put(376 + 8 * i, shift[i]);
    for (std::size_t i = 0; i < 12; ++i) put(400 + 8 * i, rows[i]);
    put(500, std::int32_t(units));
    return h;
  }

  /// The same in NIfTI-1's 348 bytes.
  std::string header_of_nifti1() const {
    Nifti one;
    for (std::size_t i = 0; i < 8; ++i) one.dims[i] = short(dims[i]);
    one.datatype = datatype;
    for (std::size_t i = 0; i < 3; ++i) one.spacing[i] = float(spacing[i + 1]);
    one.slope = float(slope), one.intercept = float(intercept);
    for (std::size_t i = 0; i < 12; ++i) one.rows[i] = float(rows[i]);
    auto h = one.header();
    const auto put = [&](std::size_t at, auto value) {
      const auto bytes = bytes_of(value);
      std::copy(bytes.begin(), bytes.end(), h.begin() + std::ptrdiff_t(at));
    };
    put(76, float(spacing[0]));
    h[123] = char(units);
    put(252, short(qform));
    put(254, short(sform));
    for (std::size_t i = 0; i < 3; ++i) put(256 + 4 * i, float(quaternion[i]));
    for (std::size_t i = 0; i < 3; ++i) put(268 + 4 * i, float(shift[i]));
    return h;
  }
};

}  // namespace files
