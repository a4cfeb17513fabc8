#pragma once
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "decode/tiff/description.hpp"
#include "images/image_file.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat::detail {

/// Where a slice's pixels are: a page that the library reads, or uncompressed bytes of the file.
struct TiffSlice {
  std::filesystem::path file;
  int page = 0;  ///< in the file's chain, from 0
  std::optional<std::uint64_t> raw_begin = std::nullopt;
  bool big_endian = false;  ///< of raw bytes
};

/// One file's planes, all of one shape.
struct TiffFile {
  std::filesystem::path path;
  int width = 0, height = 0;
  ScalarType type = ScalarType::uint8;
  int samples = 1;                     ///< numbers a pixel
  bool has_alpha = false;              ///< the last of them is opacity
  std::vector<TiffSlice> planes = {};  ///< pages but smaller copies and masks, or all planes behind one page
  Microscopy microscopy = {};          ///< without a problem; its planes are there
  /// Of each channel at each time.
  std::int64_t slices() const {
    if (microscopy.slices) return *microscopy.slices;
    const auto others = microscopy.planes(1).value_or(1);
    return std::max<std::int64_t>(1, std::int64_t(planes.size() / others));
  }
};

/// Opens an image by its library. Throws InputError when it is none.
std::unique_ptr<ImageFile> open_tiff_image(const std::filesystem::path& path);
/// What the library says; of tiles that are larger than any image, why they are not read.
std::string in_words(const std::string& problem);

/// A PNG file is one page. Throws InputError for a file that is cut short, damaged, or whose pages are no
/// single image.
TiffFile read_tiff_file(const std::filesystem::path& path);

}  // namespace ringsplat::detail
