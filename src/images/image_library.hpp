#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "images/image_file.hpp"

namespace ringsplat {

/// Takes the bytes of a written image. Throws nothing.
class ImageSink {
 public:
  /// False: they could not be written, and the file is lost.
  virtual bool write_at(std::uint64_t offset, const void* bytes, std::size_t count) = 0;
  virtual std::uint64_t size() const = 0;
  /// For formats that can only be written by name: a name to use instead, once. Empty: there is none.
  virtual std::string name_to_write_by() = 0;

 protected:
  ~ImageSink() = default;
};

/// A line of text: how much of each pixel it covers, rows from the top. The first pixel lies at (left, top)
/// from the beginning of the baseline, rightwards and downwards.
struct TextCoverage {
  int left = 0, top = 0, width = 0, height = 0;
  std::vector<float> coverage;
};

/// Implements image_file.hpp's functions in a shared library of its own. No exception leaves it.
class ImageLibrary {
 public:
  virtual OpenedImageFile open(const std::string& path) const = 0;
  /// `path` only names the format; the bytes go to the sink. Returns what went wrong, or an empty text. Check
  /// the sink, too: some writers ignore its failures.
  virtual std::string write(const std::string& path, const ImageData& image, ImageSink& sink) const = 0;
  /// UTF-8 in the TrueType font of that file. Returns what went wrong, or an empty text.
  virtual std::string draw_text(const std::string& text, int pixels, const std::string& font,
                                TextCoverage& drawn) const = 0;

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
