#include "splat/lattice_sum.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace ringsplat {
namespace {

constexpr double steps_a_half_width = 512;
/// Kernels that reach further have a lattice sum of 1 within 1e-6: its Fourier series has the quartic's
/// transform, 48 J₃(ω) / ω³, at ω = 2π · reach and beyond (Poisson's summation formula).
constexpr double smooth_reach = 64;

int steps(double half_width) {
  return static_cast<int>(std::clamp(std::ceil(steps_a_half_width / half_width), 4.0, 2048.0));
}

/// A position in a table of `size` steps a period: the step, and the rest in [0, 1]. Positions without
/// such a rest (2⁶³ and beyond, or no number) are at an end of the table.
struct Step {
  int index;
  float rest;
};
Step step_of(double position, int size) {
  // Faster than std::floor.
  const auto truncated = static_cast<double>(static_cast<std::int64_t>(position));
  const double at =
      std::min(std::max(0.0, (position - (truncated - double(truncated > position))) * size), double(size));
  const int step = std::min(static_cast<int>(at), size - 1);
  return {step, static_cast<float>(at - step)};
}

float between(float low, float high, float rest) { return low + rest * (high - low); }

/// `n` modulo `period`, in 0 … period − 1.
std::int64_t phase_of(std::int64_t n, int period) { return (n % period + period) % period; }

}  // namespace

LatticeSum::LatticeSum(const Footprint& footprint, const glm::dmat2& to_pixels)
    : to_lattice_(glm::inverse(to_pixels)), form_(footprint.p * to_pixels) {
  const glm::dmat2 inverse = glm::inverse(form_);
  reach_ = {std::hypot(inverse[0][0], inverse[1][0]), std::hypot(inverse[0][1], inverse[1][1])};
  stride_ = glm::max(glm::dvec2(1.0), glm::floor(reach_ / smooth_reach));
  weight_ = footprint.weight * stride_.x * stride_.y;
  if (const auto steps = whole_steps(to_pixels)) {
    phases_x_ = steps->x;
    phases_y_ = steps->y;
    return;
  }
  width_ = steps(1 / glm::length(form_[0]));
  height_ = steps(1 / glm::length(form_[1]));
  // A lattice is its own mirror image through a voxel, so half of the table is computed.
  const std::size_t row = static_cast<std::size_t>(width_) + 1, rows = static_cast<std::size_t>(height_) + 1;
  table_.resize(rows * row);
  for (std::size_t v = 0; v <= rows / 2; ++v)
    for (std::size_t u = 0; u < row; ++u)
      table_[v * row + u] = table_[(rows - 1 - v) * row + (row - 1 - u)] =
          static_cast<float>(1 / exact({double(u) / width_, double(v) / height_}));
}

double LatticeSum::exact(glm::dvec2 lattice) const {
  const glm::dvec2 first = glm::ceil((lattice - reach_) / stride_) * stride_, last = lattice + reach_;
  double sum = 0;
  for (double v = first.y; v <= last.y; v += stride_.y)
    for (double u = first.x; u <= last.x; u += stride_.x) {
      const glm::dvec2 r = form_ * (lattice - glm::dvec2(u, v));
      const double q = 1 - (r.x * r.x + r.y * r.y);
      if (q > 0) sum += q * q;
    }
  return sum * weight_;
}

void LatticeSum::fill_factors(std::int64_t x, std::int64_t y, glm::dvec2 voxel, float (&factors)[16]) const {
  // Computed for the same pixel wherever a row begins, so that bits are always the same.
  float of_phase[largest_step];
  for (int phase = 0; phase < phases_x_; ++phase) {
    const glm::dvec2 pixel(phase + 0.5, double(phase_of(y, phases_y_)) + 0.5),
        lattice = to_lattice_ * (pixel - voxel);
    of_phase[phase] = static_cast<float>(1 / exact(lattice - glm::floor(lattice)));
  }
  for (int column = 0; column < largest_step; ++column)
    std::fill_n(factors + std::ptrdiff_t{4} * column, 4, of_phase[phase_of(x + column, phases_x_)]);
}

void LatticeSum::divide_row(float* rgba, std::size_t count, std::int64_t x, std::int64_t y,
                            glm::dvec2 voxel) const {
  if (phases_x_ > 0) {
    float factors[16];
    fill_factors(x, y, voxel, factors);
    for (std::size_t i = 0; i < 4 * count; ++i) rgba[i] *= factors[i % 16];
    return;
  }
  // A pixel's bits do not depend on where the row begins.
  const double down = static_cast<double>(y) + 0.5 - voxel.y;
  const double u_start = to_lattice_[1][0] * down, v_start = to_lattice_[1][1] * down;
  for (std::size_t i = 0; i < count; ++i, rgba += 4) {
    const double right = static_cast<double>(x + static_cast<std::int64_t>(i)) + 0.5 - voxel.x;
    const Step u = step_of(to_lattice_[0][0] * right + u_start, width_),
               v = step_of(to_lattice_[0][1] * right + v_start, height_);
    const float* above = table_.data() + std::ptrdiff_t{v.index} * (width_ + 1) + u.index;
    const float* below = above + width_ + 1;
    const float factor =
        between(between(above[0], above[1], u.rest), between(below[0], below[1], u.rest), v.rest);
    for (int c = 0; c < 4; ++c) rgba[c] *= factor;
  }
}

}  // namespace ringsplat
