#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "splat/scene.hpp"

namespace ringsplat::test {

/// The painter's definition in double precision: no window, no table, no tiles. Colour and opacity are the
/// splats' own.
class DoublePainter {
 public:
  DoublePainter(const Footprint& footprint, int width, int height)
      : footprint_(footprint),
        width_(width),
        height_(height),
        slice_(std::size_t(4 * width * height)),
        image_(std::size_t(4 * width * height)) {
    for (std::size_t i = 3; i < image_.size(); i += 4) image_[i] = 1;
  }

  /// Returns whether a pixel of the image has Q > `margin`.
  bool draw(const Placed& placed, double margin = 0) {
    bool reached = false;
    const double opacity = static_cast<double>(placed.splat.opacity);
    const double colour[3] = {placed.splat.red / 65535.0, placed.splat.green / 65535.0,
                              placed.splat.blue / 65535.0};
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const double q = direct_q(footprint_, {x + 0.5 - placed.x, y + 0.5 - placed.y});
        if (q > margin) reached = true;
        if (q <= 0) continue;
        double* pixel = slice_.data() + 4 * (y * width_ + x);
        for (int i = 0; i < 3; ++i) pixel[i] += q * q * colour[i] * opacity;
        pixel[3] += q * q * opacity;
      }
    }
    return reached;
  }

  void composite() {
    for (std::size_t i = 0; i < slice_.size(); i += 4) {
      const double opacity = std::clamp(slice_[i + 3], 0.0, 1.0);
      for (std::size_t k = 0; k < 3; ++k)
        image_[i + k] += image_[i + 3] * std::clamp(slice_[i + k], 0.0, opacity);
      image_[i + 3] *= 1 - opacity;
    }
    std::fill(slice_.begin(), slice_.end(), 0.0);
  }

  /// Largest difference to a tile, over all channels.
  double error(const std::vector<float>& tile) const {
    double worst = 0;
    for (std::size_t i = 0; i < tile.size(); ++i) {
      const double exact = i % 4 == 3 ? 1 - image_[i] : image_[i];
      worst = std::max(worst, std::abs(static_cast<double>(tile[i]) - exact));
    }
    return worst;
  }

 private:
  Footprint footprint_;
  int width_, height_;
  std::vector<double> slice_, image_;
};

/// The painter's float32 operations one at a time, in the order that splat_sum.hpp states.
class FloatPainter {
 public:
  FloatPainter(const Footprint& footprint, int width, int height)
      : footprint_(footprint),
        reach_(kernel_reach(footprint)),
        width_(width),
        height_(height),
        slice_(std::size_t(4 * width * height)),
        image_(slice_) {}

  void draw(const Placed& placed) {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        const std::int64_t dx = x - placed.splat.anchor_x, dy = y - placed.splat.anchor_y;
        if (dx < -reach_.x || dx > reach_.x + 1 || dy < -reach_.y || dy > reach_.y + 1) continue;
        add(placed.splat, static_cast<double>(dx), static_cast<double>(dy),
            slice_.data() + 4 * (y * width_ + x));
      }
    }
  }

  void composite() {
    for (std::size_t i = 0; i < slice_.size(); i += 4) {
      const float opacity = std::clamp(slice_[i + 3], 0.0F, 1.0F);
      const float transmittance = 1.0F - image_[i + 3];
      for (std::size_t k = 0; k < 4; ++k) {
        image_[i + k] = std::fma(transmittance, std::clamp(slice_[i + k], 0.0F, opacity), image_[i + k]);
      }
    }
    std::fill(slice_.begin(), slice_.end(), 0.0F);
  }

  std::vector<float> tile() const { return image_; }

 private:
  void add(const Splat& splat, double dx, double dy, float* pixel) const {
    const auto x = static_cast<float>(dx), y = static_cast<float>(dy);
    float k = static_cast<float>(footprint_.d * dx * dx + footprint_.e * dx * dy + footprint_.f * dy * dy);
    if (2 * std::max(reach_.x, reach_.y) + 2 > 64) {
      const float u =
          std::fma(static_cast<float>(footprint_.p[0][0]), x, static_cast<float>(footprint_.p[1][0] * dy));
      const float v =
          std::fma(static_cast<float>(footprint_.p[0][1]), x, static_cast<float>(footprint_.p[1][1] * dy));
      k = -std::fma(u, u, v * v);
    }
    const float q = std::fma(splat.a, x, k) + std::fma(splat.b, y, splat.c);
    const float w = std::max(q, 0.0F), weight = w * w;
    const float scale = splat.opacity * (1.0F / 65535.0F);
    pixel[0] = std::fma(weight, static_cast<float>(splat.red) * scale, pixel[0]);
    pixel[1] = std::fma(weight, static_cast<float>(splat.green) * scale, pixel[1]);
    pixel[2] = std::fma(weight, static_cast<float>(splat.blue) * scale, pixel[2]);
    pixel[3] = std::fma(weight, splat.opacity, pixel[3]);
  }

  Footprint footprint_;
  KernelReach reach_;
  int width_, height_;
  std::vector<float> slice_, image_;
};

}  // namespace ringsplat::test
