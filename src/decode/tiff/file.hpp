#pragma once
#include <filesystem>
#include <optional>
#include <vector>

#include "decode/tiff/description.hpp"
#include "decode/tiff/source.hpp"

namespace ringsplat::detail {

/// One file's planes, all of one shape.
struct TiffFile {
  std::filesystem::path path;
  int width = 0, height = 0;
  ScalarType type = ScalarType::uint8;
  int samples = 1;                ///< numbers a pixel
  bool has_alpha = false;         ///< the last of them is opacity
  std::vector<TiffSlice> planes;  ///< pages but smaller copies and masks, or all planes behind one page
  std::optional<Microscopy> microscopy;  ///< without a problem; its planes are there
  std::int64_t slices() const;           ///< of each channel at each time
};

/// Throws InputError for a file that is cut short, damaged, or whose pages are no single image.
TiffFile read_tiff_file(const std::filesystem::path& path);

}  // namespace ringsplat::detail
