#include "sheet_engine/scalar_planes.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/huge_pages.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat {
namespace {

constexpr int side = CellRanges::side;

std::ptrdiff_t pitch_for(int width) {
  constexpr int step = 16;
  return std::ptrdiff_t(width + 2 * ScalarPlanes::margin + step - 1) / step * step;
}

template <class Number>
Number coded(const PlaneCode& code, double value) {
  if constexpr (std::is_same_v<Number, float>)
    return static_cast<float>(code.of(value));
  else
    return static_cast<Number>(std::lround(code.of(value)));
}

/// A row of a block, from any address.
template <class Number, class T>
void convert(const std::byte* from, int count, const PlaneCode& code, Number* to) {
  T values[side];
  std::memcpy(values, from, std::size_t(count) * sizeof(T));
  const bool as_stored = code.scale == 1 && !code.bounded();
  for (int i = 0; i < count; ++i) {
    if constexpr (std::is_same_v<Number, float> && std::is_same_v<T, float>)
      to[i] = as_stored && !std::isinf(values[i]) ? values[i] : coded<Number>(code, values[i]);
    else if constexpr (std::is_integral_v<T> && sizeof(T) <= 2 && std::is_integral_v<Number>)
      to[i] =
          as_stored ? static_cast<Number>(int(values[i]) - int(code.offset)) : coded<Number>(code, values[i]);
    else
      to[i] = coded<Number>(code, static_cast<double>(values[i]));
  }
}

}  // namespace

Fillers make_fillers(const TransparentValues& transparent, ScalarType type, double low, double high) {
  Fillers fillers;
  fillers.fill(low);
  fillers.back() = std::numeric_limits<double>::quiet_NaN();
  const bool whole = type != ScalarType::float32 && type != ScalarType::float64;
  for (std::size_t k = 0; k < transparent.intervals().size(); ++k) {
    const auto& i = transparent.intervals()[k];
    if (!std::isfinite(i.low))
      fillers[k] = low;
    else if (!std::isfinite(i.high))
      fillers[k] = high;
    else
      fillers[k] = !whole ? 0.5 * (i.low + i.high) : i.has_low ? std::ceil(i.low) : std::floor(i.low) + 1;
    fillers[k] = std::clamp(fillers[k], low, high);
  }
  return fillers;
}

std::size_t plane_bytes(int width, int height, bool floats) {
  return std::size_t(pitch_for(width)) * std::size_t(height + 2 * ScalarPlanes::margin) *
         (floats ? sizeof(float) : sizeof(std::int16_t));
}

void ScalarPlanes::begin_frame(int width, int height, int slots, const PlaneCode& code,
                               const Fillers& fillers) {
  const auto same_bits = [](double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; };
  const bool as_before = width == width_ && height == height_ && slots == slots_ &&
                         code.floats == code_.floats && code.offset == code_.offset &&
                         code.scale == code_.scale && code.below == code_.below &&
                         code.above == code_.above && code.least == code_.least && code.most == code_.most &&
                         std::equal(fillers.begin(), fillers.end(), fillers_.begin(), same_bits);
  if (as_before) return;
  width_ = width;
  height_ = height;
  slots_ = slots;
  code_ = code;
  fillers_ = fillers;
  columns_ = CellRanges::blocks_along(width);
  rows_ = CellRanges::blocks_along(height);
  pitch_ = pitch_for(width);
  plane_bytes_ = plane_bytes(width, height, code.floats);
  const std::size_t bytes = plane_bytes_ * std::size_t(slots);
  if (memory_.size() != bytes) {
    memory_.clear();
    memory_.shrink_to_fit();
    memory_.reserve(bytes);
    prefer_huge_pages(memory_.data(), bytes);
  }
  memory_.assign(bytes, std::byte{0});
  holds_.assign(std::size_t(columns_) * std::size_t(rows_) * std::size_t(slots), unknown);
}

template <class Number>
Number* ScalarPlanes::origin(int step) {
  return reinterpret_cast<Number*>(memory_.data() + slot_of(step) * plane_bytes_) + margin * pitch_ + margin;
}

const void* ScalarPlanes::plane(int step) const {
  auto* self = const_cast<ScalarPlanes*>(this);
  return code_.floats ? static_cast<const void*>(self->origin<float>(step))
                      : static_cast<const void*>(self->origin<std::int16_t>(step));
}

template <class Number>
void ScalarPlanes::fill(Number* voxel, int column, int row, std::uint8_t with, std::uint8_t& holds) {
  if (holds == with) return;
  holds = with;
  const Number number =
      with == BlockState::not_a_number && !code_.floats ? Number{} : coded<Number>(code_, fillers_[with]);
  const int wide = std::min(side, width_ - column * side), high = std::min(side, height_ - row * side);
  for (int y = 0; y < high; ++y) std::fill_n(voxel + y * pitch_, wide, number);
}

template <class Number>
void ScalarPlanes::place_blocks(int step, const SheetPayload& payload, ScalarType type) {
  const SheetHeader& header = payload.header;
  std::uint8_t* holds = holds_.data() + slot_of(step) * std::size_t(columns_) * std::size_t(rows_);
  const std::byte* from = payload.voxels.data();
  visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    for (int row = 0; row < rows_; ++row) {
      const int said = row - header.first_row;
      const bool any = said >= 0 && said < int(payload.rows.size());
      const BlockRow span = any ? payload.rows[std::size_t(said)] : BlockRow{};
      const int high = std::min(side, height_ - row * side);
      for (int column = 0; column < columns_; ++column, ++holds) {
        Number* voxel = origin<Number>(step) + row * side * pitch_ + column * side;
        const std::uint8_t byte = column >= span.first && column < span.end
                                      ? payload.bytes[std::size_t(said)][column - span.first]
                                      : header.elsewhere;
        if (byte < block_present) {
          fill(voxel, column, row, byte, *holds);
          continue;
        }
        *holds = unknown;
        const int wide = std::min(side, width_ - column * side);
        for (int y = 0; y < high; ++y, from += std::size_t(wide) * sizeof(T))
          convert<Number, T>(from, wide, code_, voxel + y * pitch_);
      }
    }
  });
}

template <class Number>
void ScalarPlanes::extrapolate_border(int step) {
  Number* p = origin<Number>(step);
  const auto beyond = [](Number edge, Number inner) {
    const auto value = static_cast<Number>(2 * edge - inner);
    // What lies beyond the outer voxels has no weight, but not-a-number times zero would be one.
    if constexpr (std::is_floating_point_v<Number>)
      if (!std::isfinite(value)) return edge;
    return value;
  };
  const int next = width_ > 1 ? 1 : 0;
  for (int y = 0; y < height_; ++y) {
    Number* row = p + y * pitch_;
    row[-1] = beyond(row[0], row[next]);
    row[width_] = beyond(row[width_ - 1], row[width_ - 1 - next]);
  }
  const std::ptrdiff_t down = height_ > 1 ? pitch_ : 0, last = (height_ - 1) * pitch_;
  for (int x = -1; x <= width_; ++x) {
    p[x - pitch_] = beyond(p[x], p[x + down]);
    p[x + last + pitch_] = beyond(p[x + last], p[x + last - down]);
  }
}

template <class Number>
void ScalarPlanes::place_as(int step, const SheetPayload& payload, ScalarType type) {
  place_blocks<Number>(step, payload, type);
  extrapolate_border<Number>(step);
}

void ScalarPlanes::place(int step, const SheetPayload& payload, ScalarType type) {
  if (code_.floats)
    place_as<float>(step, payload, type);
  else
    place_as<std::int16_t>(step, payload, type);
}

void ScalarPlanes::extrapolate(int step, int a, int b) {
  const std::size_t blocks = std::size_t(columns_) * std::size_t(rows_);
  std::fill_n(holds_.begin() + std::ptrdiff_t(slot_of(step) * blocks), blocks, unknown);
  const auto all = [&](auto number) {
    using Number = decltype(number);
    const std::ptrdiff_t first = -margin * pitch_ - margin,
                         count = std::ptrdiff_t(plane_bytes_ / sizeof(Number));
    Number* out = origin<Number>(step) + first;
    const Number *one = origin<Number>(a) + first, *other = origin<Number>(b) + first;
    for (std::ptrdiff_t i = 0; i < count; ++i) out[i] = static_cast<Number>(2 * one[i] - other[i]);
  };
  if (code_.floats)
    all(float{});
  else
    all(std::int16_t{});
}

}  // namespace ringsplat
