#pragma once
#include <cstdint>
#include <filesystem>
#include <vector>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat::detail {

/// The header of a NumPy array file (NumPy Enhancement Proposal 1, "numpy.lib.format"): a Python dictionary.
struct NpyHeader {
  ScalarType type = ScalarType::uint8;
  bool half = false;  ///< the voxels are binary16; `type` is uint16
  bool big_endian = false;
  bool fortran_order = false;       ///< the first axis is the fastest, else the last
  std::vector<std::int64_t> shape;  ///< as NumPy has it
  std::uint64_t end = 0;            ///< the byte after the header
};

/// Throws InputError for damaged headers, and for types that no volume may have, with what to do.
NpyHeader read_npy_header(const std::filesystem::path& path);

}  // namespace ringsplat::detail
