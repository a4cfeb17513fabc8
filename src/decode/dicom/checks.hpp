#pragma once
#include <cstdint>
#include <vector>

#include "decode/dicom/elements.hpp"
#include "formats/stored_source.hpp"

namespace ringsplat::detail {

enum class DicomCodec { none, rle, jpeg, jpeg_2000 };  ///< jpeg: all kinds of it that are of segments

/// A file's description of its pixels; each number is within its allowed range.
struct DicomShape {
  int rows = 0, columns = 0, frames = 1;
  int bits_allocated = 0, bits_stored = 0, high_bit = 0;
  bool is_signed = false;
  DicomCodec codec = DicomCodec::none;

  std::uint64_t bytes_per_voxel() const { return std::uint64_t(bits_allocated) / 8; }
  std::uint64_t bytes() const {
    return std::uint64_t(rows) * std::uint64_t(columns) * std::uint64_t(frames) * bytes_per_voxel();
  }
};

/// Checks what GDCM would take on trust, or draw otherwise than the file means: numbers, these against each
/// other, and the amount of pixels. Throws InputError naming the element.
DicomShape check_dicom(const DicomFile& file);

/// The type of pixels as they are stored.
ScalarType stored_type(const DicomShape& shape);

/// The type of rescaled pixels: where these are whole numbers the narrowest that has all values of the bits
/// stored, else float64. Where it is narrower than the stored type, all bits of uncompressed pixels count, of
/// which `shape` is told.
ScalarType rescaled_type(const DicomFile& file, DicomShape& shape, const Rescale& rescale);

/// The numbers of an element. Throws InputError for what is no number, or for a wrong count of numbers. Empty
/// when the item lacks the element.
std::vector<double> checked_numbers(const DicomFile& file, const DicomItem& item, DicomTag tag);

}  // namespace ringsplat::detail
