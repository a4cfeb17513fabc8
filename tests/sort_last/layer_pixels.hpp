#pragma once
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/image.hpp"
#include "screen/regions.hpp"

namespace ringsplat::sort_last {

/// To the nearest half, ties to even. `value`: finite, at most 65504 in magnitude.
inline std::uint16_t half_of(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = bits >> 16 & 0x8000U, magnitude = bits & 0x7fffffffU;
  // Below the normal halves an addition rounds to their steps.
  if (magnitude < 0x38800000U) {
    const float shifted = std::bit_cast<float>(magnitude) + 0.5F;
    return std::uint16_t(sign | (std::bit_cast<std::uint32_t>(shifted) - 0x3f000000U));
  }
  const std::uint32_t odd = magnitude >> 13 & 1U;
  return std::uint16_t(sign | ((magnitude - 0x38000000U + 0xfffU + odd) >> 13));
}
inline float float_of(std::uint16_t half) {
  const std::uint32_t sign = std::uint32_t(half & 0x8000U) << 16, magnitude = half & 0x7fffU;
  const float value = magnitude < 0x400U ? float(magnitude) * 0x1p-24F
                                         : std::bit_cast<float>((magnitude << 13) + 0x38000000U);
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) | sign);
}

template <class T>
void put(Bytes& bytes, const T& value) {
  const auto* from = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), from, from + sizeof value);
}
template <class T>
T take(std::span<const std::byte>& bytes) {
  T value;
  std::memcpy(&value, bytes.data(), sizeof value);
  bytes = bytes.subspan(sizeof value);
  return value;
}

/// A run of pixels of a region, after so many transparent ones.
struct PixelRun {
  std::uint16_t skipped = 0, pixels = 0;
};

/// Appends a region: how many runs, and for each a PixelRun and its pixels, as halves or floats.
inline void put_region(const Image& image, const PixelRect& rect, bool halves, Bytes& bytes) {
  const std::size_t at = bytes.size();
  put(bytes, std::uint16_t{0});
  std::uint16_t runs = 0;
  PixelRun run;
  std::size_t run_at = 0;
  const auto close = [&] {
    if (run.pixels > 0) std::memcpy(bytes.data() + run_at, &run, sizeof run);
    run = {};
  };
  for (int y = rect.y0; y < rect.y1; ++y)
    for (int x = rect.x0; x < rect.x1; ++x) {
      const float* pixel = image.pixel(x, y);
      if (pixel[3] == 0) {
        if (run.pixels > 0) close();
        ++run.skipped;
        continue;
      }
      if (run.pixels++ == 0) {
        ++runs;
        run_at = bytes.size();
        put(bytes, run);
      }
      for (int c = 0; c < 4; ++c)
        if (halves)
          put(bytes, half_of(pixel[c]));
        else
          put(bytes, pixel[c]);
    }
  close();
  std::memcpy(bytes.data() + at, &runs, sizeof runs);
}

/// Bytes of a region of so many pixels at most.
inline std::size_t most_region_bytes(std::size_t pixels, bool halves) {
  return 2 + pixels * ((halves ? 8 : 16) + sizeof(PixelRun));
}

/// Takes what put_region() appended and composites it behind the image. Returns how many pixels it had.
inline std::size_t composite_region(std::span<const std::byte>& bytes, const PixelRect& rect, bool halves,
                                    float opaque_threshold, Image& image) {
  std::size_t at = 0, count = 0;
  for (int runs = take<std::uint16_t>(bytes); runs > 0; --runs) {
    const auto run = take<PixelRun>(bytes);
    at += run.skipped;
    count += run.pixels;
    for (std::size_t k = 0; k < run.pixels; ++k, ++at) {
      float* under = image.pixel(rect.x0 + int(at) % rect.width(), rect.y0 + int(at) / rect.width());
      const float left = 1 - under[3];
      for (int c = 0; c < 4; ++c) {
        const float value = halves ? float_of(take<std::uint16_t>(bytes)) : take<float>(bytes);
        if (left >= opaque_threshold) under[c] += left * value;
      }
    }
  }
  return count;
}

}  // namespace ringsplat::sort_last
