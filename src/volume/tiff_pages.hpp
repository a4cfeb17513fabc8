#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

namespace ringsplat::detail {

/// Counts the directories (pages) of a TIFF or BigTIFF file (TIFF 6.0, section 2) and checks that they and
/// their strips or tiles lie in the file. In a cut file the library takes a chain that leads beyond the end
/// for the last page, and missing strips for zeros; here both throw InputError. Returns 0 for a file that is
/// not TIFF.
std::uint64_t count_tiff_pages(const std::filesystem::path& path);

/// The first page's notes beside its pixels; empty and 0 when missing.
struct TiffNotes {
  std::string description;                 ///< tag ImageDescription
  std::array<double, 2> resolution{0, 0};  ///< tags XResolution and YResolution: pixels for a unit
};
/// Reads the notes of a file whose pages were counted.
TiffNotes read_tiff_notes(const std::filesystem::path& path);

}  // namespace ringsplat::detail
