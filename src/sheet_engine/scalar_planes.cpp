#include "sheet_engine/scalar_planes.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <numeric>

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

/// A row of a block, from any address. `count` may be known when this is compiled, so that rows go at once.
template <class Number, class T>
void convert(const std::byte* from, auto count, const PlaneCode& code, Number* to) {
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
  slots_hold_.assign(std::size_t(slots), {});
  for (Slot& slot : slots_hold_) slot.holds.assign(blocks(), unknown);
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

/// Differences at a border read one number beyond it, and that of the next block if the last has one voxel.
void ScalarPlanes::note_change(int column, int row) {
  if (column == 0 || column >= columns_ - 2) changed_rows_.add(row * side, row * side + high(row));
  if (row == 0 || row >= rows_ - 2) changed_columns_.add(column * side, column * side + wide(column));
}

template <class Number>
void ScalarPlanes::fill(Number* plane, Slot& slot, std::uint32_t block, std::uint8_t with) {
  if (slot.holds[block] == with) return;
  slot.holds[block] = with;
  const Number number =
      with == BlockState::not_a_number && !code_.floats ? Number{} : coded<Number>(code_, fillers_[with]);
  const int column = int(block) % columns_, row = int(block) / columns_;
  Number* voxel = plane + place_of(block);
  for (int y = 0; y < high(row); ++y) std::fill_n(voxel + y * pitch_, wide(column), number);
  note_change(column, row);
}

template <class Number>
void ScalarPlanes::fill_all(Number* plane, Slot& slot, std::uint8_t with) {
  const auto fill_one = [&](std::uint32_t block) { fill(plane, slot, block, with); };
  if (slot.elsewhere == with)
    std::for_each(slot.others.begin(), slot.others.end(), fill_one);
  else
    for (std::uint32_t block = 0; block < blocks(); ++block) fill_one(block);
  slot.elsewhere = with;
  slot.others.clear();
}

template <class Number, class T>
void ScalarPlanes::place_blocks(Number* plane, Slot& slot, const SheetPayload& payload) {
  const std::uint8_t elsewhere = payload.header.elsewhere;
  if (slot.elsewhere != elsewhere) fill_all(plane, slot, elsewhere);
  auto before = slot.others.begin();
  const auto forget_up_to = [&](std::uint32_t block) {
    for (; before != slot.others.end() && *before < block; ++before) fill(plane, slot, *before, elsewhere);
    if (before != slot.others.end() && *before == block) ++before;
  };
  const std::byte* from = payload.voxels.data();
  others_.clear();
  for (std::size_t said = 0; said < payload.rows.size(); ++said) {
    const BlockRow& span = payload.rows[said];
    const int row = payload.header.first_row + int(said);
    for (int column = span.first; column < span.end; ++column) {
      const std::uint8_t byte = payload.bytes[said][column - span.first];
      if (byte == elsewhere) continue;
      const auto block = std::uint32_t(row * columns_ + column);
      forget_up_to(block);
      others_.push_back(block);
      if (byte < block_present) {
        fill(plane, slot, block, byte);
        continue;
      }
      slot.holds[block] = unknown;
      note_change(column, row);
      Number* voxel = plane + place_of(block);
      const auto place_rows = [&](auto across) {
        for (int y = 0; y < high(row); ++y, from += std::size_t(across) * sizeof(T))
          convert<Number, T>(from, across, code_, voxel + y * pitch_);
      };
      if (wide(column) == side)
        place_rows(std::integral_constant<int, side>());
      else
        place_rows(wide(column));
    }
  }
  forget_up_to(blocks());
  slot.others.swap(others_);
}

namespace {

template <class Number>
Number beyond(Number edge, Number inner) {
  const auto value = static_cast<Number>(2 * edge - inner);
  // What lies beyond the outer voxels has no weight, but not-a-number times zero would be one.
  if constexpr (std::is_floating_point_v<Number>)
    if (!std::isfinite(value)) return edge;
  return value;
}

}  // namespace

template <class Number>
void ScalarPlanes::extrapolate_border(Number* p) {
  const int next = width_ > 1 ? 1 : 0;
  for (int y = changed_rows_.first; y < changed_rows_.end; ++y) {
    Number* row = p + y * pitch_;
    row[-1] = beyond(row[0], row[next]);
    row[width_] = beyond(row[width_ - 1], row[width_ - 1 - next]);
  }
  const std::ptrdiff_t down = height_ > 1 ? pitch_ : 0, last = (height_ - 1) * pitch_;
  const Span& x = changed_columns_;
  if (x.first == x.end) return;
  // The corners follow the borders beside them.
  const int from = x.first == 0 ? -1 : x.first, to = x.end >= width_ - 1 ? width_ : x.end - 1;
  for (int at = from; at <= to; ++at) {
    p[at - pitch_] = beyond(p[at], p[at + down]);
    p[at + last + pitch_] = beyond(p[at + last], p[at + last - down]);
  }
}

template <class Number>
void ScalarPlanes::place_as(int step, const SheetPayload& payload, ScalarType type) {
  changed_columns_ = changed_rows_ = {};
  Number* plane = origin<Number>(step);
  visit_type(type, [&](auto zero) {
    place_blocks<Number, decltype(zero)>(plane, slots_hold_[slot_of(step)], payload);
  });
  extrapolate_border(plane);
}

void ScalarPlanes::place(int step, const SheetPayload& payload, ScalarType type) {
  if (code_.floats)
    place_as<float>(step, payload, type);
  else
    place_as<std::int16_t>(step, payload, type);
}

template <class Number>
void ScalarPlanes::extrapolate_block(Number* out, const Number* one, const Number* other,
                                     std::uint32_t block) const {
  const std::ptrdiff_t place = place_of(block);
  const int across = wide(int(block) % columns_), down = high(int(block) / columns_);
  for (int y = 0; y < down; ++y)
    for (std::ptrdiff_t at = place + y * pitch_, end = at + across; at < end; ++at)
      out[at] = static_cast<Number>(2 * one[at] - other[at]);
}

template <class Number>
void ScalarPlanes::extrapolate_margin(Number* out, const Number* one, const Number* other) const {
  const auto at = [&](std::ptrdiff_t place) {
    out[place] = static_cast<Number>(2 * one[place] - other[place]);
  };
  for (int y = 0; y < height_; ++y) {
    at(y * pitch_ - 1);
    at(y * pitch_ + width_);
  }
  for (int x = -1; x <= width_; ++x) {
    at(x - pitch_);
    at(x + height_ * pitch_);
  }
}

template <class Number>
void ScalarPlanes::extrapolate_as(int step, int a, int b) {
  Number* out = origin<Number>(step);
  const Number *one = origin<Number>(a), *other = origin<Number>(b);
  Slot& slot = slots_hold_[slot_of(step)];
  const Slot &before = slots_hold_[slot_of(a)], &after = slots_hold_[slot_of(b)];
  others_.clear();
  if (before.elsewhere == after.elsewhere && before.elsewhere != unknown) {
    // Where both hold the same filler the extrapolation is that.
    fill_all(out, slot, before.elsewhere);
    std::set_union(before.others.begin(), before.others.end(), after.others.begin(), after.others.end(),
                   std::back_inserter(others_));
  } else {
    slot.elsewhere = unknown;
    others_.resize(blocks());
    std::iota(others_.begin(), others_.end(), 0U);
  }
  for (const std::uint32_t block : others_) {
    extrapolate_block(out, one, other, block);
    slot.holds[block] = unknown;
  }
  slot.others.swap(others_);
  extrapolate_margin(out, one, other);
}

void ScalarPlanes::extrapolate(int step, int a, int b) {
  if (code_.floats)
    extrapolate_as<float>(step, a, b);
  else
    extrapolate_as<std::int16_t>(step, a, b);
}

}  // namespace ringsplat
