#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/encoded_bytes.hpp"
#include "formats/signatures.hpp"
#include "ringsplat/volume/source.hpp"

namespace ringsplat::detail {

/// value = slope * stored + intercept.
struct Rescale {
  double slope = 1, intercept = 0;
};

/// Makes values of type `from` such of type `to`.
void apply(const Rescale& rescale, ScalarType from, std::span<const std::byte> in, ScalarType to,
           std::span<std::byte> out);

/// A type of numbers: NumPy's name without the byte order, and Zarr 3's.
struct NumberType {
  std::string_view code, name;
  ScalarType type;  ///< of voxels, which hold every value of all but 64-bit integers
  std::size_t bytes() const { return std::size_t(code[1] - '0'); }
};
/// By either name; null for others.
const NumberType* number_type(std::string_view name);

/// The type that scalar_type_from() knows by this name. Throws InputError for others.
ScalarType voxel_type(const std::filesystem::path& file, const std::string& name);

/// Makes binary32 of IEEE 754 binary16.
void widen_halves(std::span<const std::byte> halves, std::span<std::byte> floats);
/// Makes float64 of 64-bit integers, in place. Throws InputError, with `where`, for one that has none
/// exactly.
void doubles_of_integers(std::span<std::byte> values, bool is_signed, const std::string& where);

/// Where and how a file holds its voxels, x fastest, without gaps.
struct StoredVoxels {
  std::filesystem::path file;
  std::uint64_t offset = 0;  ///< bytes of the file before the voxels, or before the compressed stream
  Encoding encoding = Encoding::raw;  ///< not base64
  std::uint64_t skip = 0;             ///< decoded bytes before the voxels, when compressed
  std::uint64_t end = file_end;       ///< the byte of the file that text ends before
  bool big_endian = false;
  ScalarType type = ScalarType::uint8;
  bool half = false;  ///< they are binary16, `type` is uint16 and grid.type float32
  /// When set, grid.type is one that holds what it makes of the values.
  std::optional<Rescale> rescale = std::nullopt;

  /// The bytes before the voxels, of what the file holds where it is compressed.
  std::uint64_t& before() { return encoding == Encoding::deflate ? skip : offset; }
  /// Of `count` volumes of `bytes` bytes, one behind another, makes it the volume `index`. Throws InputError
  /// when the file cannot hold them all.
  void choose(std::uint64_t bytes, std::int64_t count, std::int64_t index);
  /// Fills `head` with the first bytes of what the file holds.
  void read_head(std::span<std::byte> head) const;
};

/// Voxels of a file that gzip may have compressed.
inline StoredVoxels stored_in(const std::filesystem::path& file) {
  return {.file = file, .encoding = is_gzip(file) ? Encoding::deflate : Encoding::raw};
}

/// A volume that one file holds, or several behind each other, equally many voxels in each: whole slices,
/// whole rows of one slice, or a part of a row. Reads uncompressed slices by position (concurrent); decodes
/// others in order and keeps only a window and the slices asked for. Opens every file, so that one which is
/// missing, or too short for the grid (a compressed one at deflate's best ratio), is an InputError at once.
std::unique_ptr<VolumeSource> stored_source(const Grid& grid, std::vector<StoredVoxels> pieces);

}  // namespace ringsplat::detail
