#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace ringsplat::detail {

/// A directory (page) of a TIFF file.
struct TiffPage {
  bool beside = false;   ///< a smaller copy of another page, or a mask
  bool palette = false;  ///< its pixels are indices of colours
  /// Where its pixels lie when they are uncompressed and in one piece, else 0 bytes.
  std::uint64_t raw_begin = 0, raw_bytes = 0;
};
struct TiffPages {
  bool big_endian = false;
  std::vector<TiffPage> pages;  ///< in the order of the file's chain
};

/// Reads the directories of a TIFF or BigTIFF file (TIFF 6.0, section 2) and checks that they and their
/// strips or tiles lie in the file. In a cut file the library takes a chain that leads beyond the end for the
/// last page, and missing strips for zeros; here both throw InputError. A file that is not TIFF has no pages.
TiffPages read_tiff_pages(const std::filesystem::path& path);

/// The first page's notes beside its pixels; empty and 0 when missing.
struct TiffNotes {
  std::string description;                 ///< tag ImageDescription
  std::array<double, 2> resolution{0, 0};  ///< tags XResolution and YResolution: pixels for a unit
};
/// Reads the notes of a file whose pages were read.
TiffNotes read_tiff_notes(const std::filesystem::path& path);

}  // namespace ringsplat::detail
