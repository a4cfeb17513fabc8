#pragma once
#include "ringsplat/images/image_file.hpp"

namespace ringsplat {

/// What is behind the functions of image_file.hpp, in a shared library of its own. No exception leaves it.
class ImageLibrary {
 public:
  virtual OpenedImageFile open(const std::string& path) const = 0;
  virtual std::string write(const std::string& path, const ImageData& image) const = 0;

 protected:
  ~ImageLibrary() = default;
};

/// Loads the shared library that has it. Throws RunError when that fails.
const ImageLibrary& image_library_of(const char* shared_library);

}  // namespace ringsplat

/// What the shared library exports.
extern "C" const ringsplat::ImageLibrary* ringsplat_image_library();
