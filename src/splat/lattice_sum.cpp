#include "splat/lattice_sum.hpp"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "splat/lattice_factors.hpp"
#include "splat/whole_steps.hpp"

namespace ringsplat {

namespace {

constexpr double steps_a_half_width = 512;
/// Kernels that reach further have a lattice sum of 1 within 1e-6: its Fourier series has the quartic's
/// transform, 48 J₃(ω) / ω³, at ω = 2π · reach and beyond (Poisson's summation formula).
constexpr double smooth_reach = 64;

int steps(double half_width) {
  return static_cast<int>(std::clamp(std::ceil(steps_a_half_width / half_width), 4.0, 2048.0));
}

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

float LatticeSum::reciprocal(glm::dvec2 lattice) const {
  if (phases_x_ > 0) return static_cast<float>(1 / exact(lattice));
  float factors[8];
  lattice_factors({.table = table_.data(),
                   .width = width_,
                   .height = height_,
                   .u_start = lattice.x,
                   .v_start = lattice.y},
                  0, 1, factors);
  return factors[0];
}

/// Computed for the same pixel wherever a row begins, so that its bits are always the same.
float LatticeSum::factor_of_phase(int x, int y, glm::dvec2 voxel) const {
  const glm::dvec2 lattice = to_lattice_ * (glm::dvec2(x + 0.5, y + 0.5) - voxel);
  return reciprocal(lattice - glm::floor(lattice));
}

void LatticeSum::fill_factors(std::int64_t x, std::int64_t y, glm::dvec2 voxel,
                              float (&factors)[4][16]) const {
  float of_phase[largest_step][largest_step];
  for (int v = 0; v < phases_y_; ++v)
    for (int u = 0; u < phases_x_; ++u) of_phase[v][u] = factor_of_phase(u, v, voxel);
  for (int row = 0; row < largest_step; ++row)
    for (int column = 0; column < largest_step; ++column)
      std::fill_n(factors[row] + std::ptrdiff_t{4} * column, 4,
                  of_phase[phase_of(y + row, phases_y_)][phase_of(x + column, phases_x_)]);
}

void LatticeSum::divide_by_phases(float* rgba, std::size_t count, std::int64_t x, std::int64_t y,
                                  glm::dvec2 voxel) const {
  float factors[largest_step];
  for (int phase = 0; phase < phases_x_; ++phase)
    factors[phase] = factor_of_phase(phase, int(phase_of(y, phases_y_)), voxel);
  auto phase = phase_of(x, phases_x_);
  for (std::size_t i = 0; i < count; ++i, rgba += 4) {
    for (int c = 0; c < 4; ++c) rgba[c] *= factors[phase];
    phase = phase + 1 == phases_x_ ? 0 : phase + 1;
  }
}

void LatticeSum::divide_row(float* rgba, std::size_t count, std::int64_t x, std::int64_t y,
                            glm::dvec2 voxel) const {
  if (phases_x_ > 0) {
    divide_by_phases(rgba, count, x, y, voxel);
    return;
  }
  const double down = static_cast<double>(y) + 0.5 - voxel.y;
  const LatticeRow row{.table = table_.data(),
                       .width = width_,
                       .height = height_,
                       .voxel_x = voxel.x,
                       .u_step = to_lattice_[0][0],
                       .u_start = to_lattice_[1][0] * down,
                       .v_step = to_lattice_[0][1],
                       .v_start = to_lattice_[1][1] * down};
  constexpr std::size_t at_once = 256;
  float factors[at_once + 8];
  for (std::size_t first = 0; first < count; first += at_once) {
    const std::size_t some = std::min(at_once, count - first);
    lattice_factors(row, x + static_cast<std::int64_t>(first), some, factors);
    for (std::size_t i = 0; i < some; ++i, rgba += 4)
      for (int c = 0; c < 4; ++c) rgba[c] *= factors[i];
  }
}

}  // namespace ringsplat
