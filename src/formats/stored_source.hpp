#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// value = slope * stored + intercept.
struct Rescale {
  double slope = 1, intercept = 0;
};

/// Makes values of type `from` such of type `to`.
void apply(const Rescale& rescale, ScalarType from, std::span<const std::byte> in, ScalarType to,
           std::span<std::byte> out);

/// Where and how a file holds its voxels, x fastest, without gaps.
struct StoredVoxels {
  std::filesystem::path file;
  std::uint64_t offset = 0;  ///< bytes of the file before the voxels, or before the compressed stream
  bool compressed = false;   ///< gzip or zlib
  std::uint64_t skip = 0;    ///< decoded bytes before the voxels, when compressed
  bool big_endian = false;
  ScalarType type = ScalarType::uint8;
  /// When set, grid.type is float32, or float64 for stored float64.
  std::optional<Rescale> rescale = std::nullopt;
};

/// Reads uncompressed slices by position (concurrent); decodes compressed ones in order and keeps only a
/// window and the slices asked for. Throws InputError when the file is too short for the grid, for a
/// compressed file at deflate's best ratio.
std::unique_ptr<VolumeSource> stored_source(const Grid& grid, StoredVoxels stored);

}  // namespace ringsplat::detail
