#include "splat/lattice_sum.hpp"

#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/lattice_sum.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#ifndef RINGSPLAT_LATTICE_SUM_ONCE
#define RINGSPLAT_LATTICE_SUM_ONCE
namespace ringsplat {
namespace {

/// A table of one lattice cell, and a row of pixels as a line through the lattice.
struct LatticeRow {
  const float* table = nullptr;  ///< [height + 1][width + 1], of a function with period 1 in u and v
  int width = 1, height = 1;     ///< steps a cell
  double voxel_x = 0;            ///< pixels; u and v count from there
  double u_step = 0, u_start = 0, v_step = 0, v_start = 0;  ///< u = u_step · right + u_start
};

}  // namespace
}  // namespace ringsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;
using HalfFloats = hn::Rebind<float, Doubles>;
using HalfInts = hn::Rebind<std::int32_t, Doubles>;

/// Positions in a table of `size` steps a period: the step, and the rest in [0, 1].
struct Steps {
  hn::Vec<HalfInts> index;
  hn::Vec<HalfFloats> rest;
};
HWY_INLINE Steps steps_of(hn::Vec<Doubles> position, int size) {
  const Doubles d;
  const auto at = hn::Mul(hn::Sub(position, hn::Floor(position)), hn::Set(d, static_cast<double>(size)));
  const auto step = hn::Min(hn::Floor(at), hn::Set(d, size - 1.0));
  return {hn::DemoteTo(HalfInts(), step), hn::DemoteTo(HalfFloats(), hn::Sub(at, step))};
}

/// Interpolates the table linearly at the centres of the pixels x, x + 1 … of the row. A pixel's bits depend
/// neither on where the row begins nor on the vector width. Writes up to seven floats beyond `count`.
void LatticeFactors(const LatticeRow& row, std::int64_t x, std::size_t count, float* factors) {
  const Doubles d;
  const HalfFloats half;
  const HalfInts ints;
  const auto between = [](auto low, auto high, auto rest) {
    return hn::Add(low, hn::Mul(rest, hn::Sub(high, low)));
  };
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto column = hn::Iota(d, static_cast<double>(x + static_cast<std::int64_t>(i)));
    const auto right = hn::Sub(hn::Add(column, hn::Set(d, 0.5)), hn::Set(d, row.voxel_x));
    const Steps u =
        steps_of(hn::Add(hn::Mul(hn::Set(d, row.u_step), right), hn::Set(d, row.u_start)), row.width);
    const Steps v =
        steps_of(hn::Add(hn::Mul(hn::Set(d, row.v_step), right), hn::Set(d, row.v_start)), row.height);
    const auto at = hn::Add(hn::Mul(v.index, hn::Set(ints, row.width + 1)), u.index);
    const float* below = row.table + row.width + 1;
    const auto first =
        between(hn::GatherIndex(half, row.table, at), hn::GatherIndex(half, row.table + 1, at), u.rest);
    const auto second =
        between(hn::GatherIndex(half, below, at), hn::GatherIndex(half, below + 1, at), u.rest);
    hn::StoreU(between(first, second, v.rest), half, factors + i);
  }
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(LatticeFactors);

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

/// Computed for the same pixel wherever a row begins, so that its bits are always the same.
float LatticeSum::factor_of_phase(int x, int y, glm::dvec2 voxel) const {
  const glm::dvec2 lattice = to_lattice_ * (glm::dvec2(x + 0.5, y + 0.5) - voxel);
  return static_cast<float>(1 / exact(lattice - glm::floor(lattice)));
}

void LatticeSum::fill_factors(std::int64_t x, std::int64_t y, glm::dvec2 voxel, float (&factors)[16]) const {
  float of_phase[largest_step];
  for (int phase = 0; phase < phases_x_; ++phase)
    of_phase[phase] = factor_of_phase(phase, int(phase_of(y, phases_y_)), voxel);
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
    HWY_DYNAMIC_DISPATCH(LatticeFactors)(row, x + static_cast<std::int64_t>(first), some, factors);
    for (std::size_t i = 0; i < some; ++i, rgba += 4)
      for (int c = 0; c < 4; ++c) rgba[c] *= factors[i];
  }
}

}  // namespace ringsplat
#endif
