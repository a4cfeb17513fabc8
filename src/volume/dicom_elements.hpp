#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>

namespace ringsplat::detail {

/// What the file says of its pixels before GDCM sees it; 0 where it says nothing.
struct DicomElements {
  bool has_pixels = false;
  bool followed = true;
  int samples = 1, rows = 0, columns = 0, bits_allocated = 0;
  /// Length of uncompressed pixel data; none when compressed, or where the elements were not followed.
  std::optional<std::uint64_t> pixel_bytes = std::nullopt;
};

/// Follows the element headers of a DICOM file (PS3.10 section 7, PS3.5 section 7) up to the pixel data
/// and checks that every element lies within the file, because GDCM ends the process with an assertion
/// when a header is cut, and fills up with zeros when pixels are. Big-endian and deflated data sets, both
/// retired or rare, are not followed. Returns nothing for a file that is not DICOM; throws InputError
/// for one that is cut short or damaged.
std::optional<DicomElements> follow_dicom_elements(const std::filesystem::path& path);

}  // namespace ringsplat::detail
