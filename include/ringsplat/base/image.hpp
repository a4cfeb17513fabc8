#pragma once
#include <cstddef>
#include <vector>

#include "ringsplat/base/bytes.hpp"

namespace ringsplat {

/// Premultiplied linear RGBA, float32, rows from the top, four floats a pixel.
struct Image {
  /// Growing leaves new elements uninitialised.
  using Floats = std::vector<float, UninitialisedAllocator<float>>;

  int width = 0, height = 0;
  Floats rgba;
  Floats depth;  ///< where Shown::depth asks for it, else none: a number a pixel, infinite where nothing is

  Image() = default;
  /// A fully transparent image.
  Image(int w, int h) : width(w), height(h), rgba(std::size_t(4) * std::size_t(w) * std::size_t(h), 0.0F) {}
  /// Uninitialised pixels: write all of them.
  static Image uninitialised(int w, int h) {
    Image image;
    image.width = w;
    image.height = h;
    image.rgba.resize(std::size_t(4) * std::size_t(w) * std::size_t(h));
    return image;
  }
  float* pixel(int x, int y) {
    return rgba.data() + 4 * (std::size_t(y) * std::size_t(width) + std::size_t(x));
  }
  const float* pixel(int x, int y) const {
    return rgba.data() + 4 * (std::size_t(y) * std::size_t(width) + std::size_t(x));
  }
  bool operator==(const Image&) const = default;
};

}  // namespace ringsplat
