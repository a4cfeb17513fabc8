#pragma once
#include <string>

#include "images/drawing.hpp"
#include "images/image_file.hpp"

namespace ringsplat {

/// What write() returns when the file does not fit into memory.
inline constexpr const char* no_memory = "there is not enough memory";

/// Implements image_file.hpp's functions in a shared library of its own. No exception leaves it.
class ImageLibrary {
 public:
  virtual OpenedImageFile open(const std::string& path) const = 0;
  /// Makes the bytes of a file; `path` only names its format. What can only be written by name goes into
  /// `spare`, an empty file, and `file` stays empty. Returns what went wrong, or an empty text.
  virtual std::string write(const std::string& path, const ImageData& image, const std::string& spare,
                            Bytes& file) const = 0;
  /// A line of UTF-8 in the TrueType font of that file; its baseline begins at (0, 0). Returns what went
  /// wrong, or an empty text.
  virtual std::string draw_text(const std::string& text, int pixels, const std::string& font,
                                Mask& drawn) const = 0;

 protected:
  ~ImageLibrary() = default;
};

/// Loads that shared library. Throws RunError when that fails.
const ImageLibrary& image_library_of(const char* shared_library);
/// This build's own.
const ImageLibrary& image_library();

}  // namespace ringsplat

/// What the shared library exports.
extern "C" const ringsplat::ImageLibrary* ringsplat_image_library();
