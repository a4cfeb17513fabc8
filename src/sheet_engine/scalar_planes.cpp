#include "sheet_engine/scalar_planes.hpp"

#include <fmt/format.h>

#include <cstring>
#include <iterator>

#include "base/byte_stream.hpp"

namespace ringsplat {
namespace {

constexpr int side = CellRanges::side;

std::ptrdiff_t pitch_for(int width) {
  constexpr int step = 16;
  return std::ptrdiff_t(width + 2 * ScalarPlanes::margin + step - 1) / step * step;
}

template <class Number>
Number coded(const PlaneCode& code, double value) {
  const double number = code.of(value);
  if constexpr (std::is_same_v<Number, float>) return static_cast<float>(number);
  // As std::lround, which is a call: added to the number below a half, this stays below one.
  return static_cast<Number>(static_cast<int>(number + std::copysign(0x1.fffffffffffffp-2, number)));
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// A row of a block, from any address. `count` may be known when this is compiled, so that rows go at once.
template <class Number, class T>
void convert(const std::byte* from, auto count, const PlaneCode& code, Number* to) {
  T values[side];
  std::memcpy(values, from, std::size_t(count) * sizeof(T));
  const bool as_stored = code.scale == 1 && !code.bounded();
  for (int i = 0; i < count; ++i) {
    if constexpr (std::is_same_v<Number, float> && std::is_same_v<T, float>)
      to[i] = as_stored && code.offset == 0 && !std::isinf(values[i]) ? values[i]
                                                                      : coded<Number>(code, values[i]);
    else if constexpr (std::is_integral_v<T> && sizeof(T) <= 2 && std::is_integral_v<Number>)
      to[i] =
          as_stored ? static_cast<Number>(int(values[i]) - int(code.offset)) : coded<Number>(code, values[i]);
    else
      to[i] = coded<Number>(code, static_cast<double>(values[i]));
  }
}

template <class Number>
Number beyond(Number edge, Number inner) {
  const auto value = static_cast<Number>(2 * edge - inner);
  // What lies beyond the outer voxels has no weight, but not-a-number times zero would be one.
  if constexpr (std::is_floating_point_v<Number>)
    if (!std::isfinite(value)) return edge;
  return value;
}

}  // namespace

std::size_t plane_bytes(int width, int height, const PlaneCode& code) {
  return std::size_t(pitch_for(width)) * std::size_t(height + 2 * ScalarPlanes::margin) *
         ((code.floats ? sizeof(float) : sizeof(std::int16_t)) + (code.labelled ? 1 : 0));
}

void ScalarPlanes::begin_frame(int width, int height, int slots, const PlaneCode& code,
                               const Fillers& fillers) {
  shelf_.reset();
  plane_of_step_.clear();
  const bool same_fillers = std::equal(fillers.begin(), fillers.end(), fillers_.begin(), same_bits);
  if (width == width_ && height == height_ && slots == slots_ && code == code_ && same_fillers) return;
  width_ = width;
  height_ = height;
  slots_ = slots;
  code_ = code;
  fillers_ = fillers;
  columns_ = CellRanges::blocks_along(width);
  rows_ = CellRanges::blocks_along(height);
  pitch_ = pitch_for(width);
  plane_bytes_ = plane_bytes(width, height, code);
  empty(passing_);
  passing_.slots.resize(std::size_t(slots));
}

ScalarPlanes::PlaneMemory ScalarPlanes::memory_of_step(int step) {
  const auto at = std::size_t(step + 1);
  if (at < plane_of_step_.size() && plane_of_step_[at] != no_plane)
    return plane_on(shelves_[shelf_->shelf], plane_of_step_[at]);
  return plane_on(passing_, at % std::size_t(slots_));
}

template <class Number>
Number* ScalarPlanes::origin(std::byte* memory) const {
  return reinterpret_cast<Number*>(memory) + margin * pitch_ + margin;
}

const void* ScalarPlanes::plane(int step) const {
  std::byte* memory = const_cast<ScalarPlanes*>(this)->memory_of_step(step).memory;
  return code_.floats ? static_cast<const void*>(origin<float>(memory))
                      : static_cast<const void*>(origin<std::int16_t>(memory));
}

/// Behind the numbers.
std::uint8_t* ScalarPlanes::labels_of(std::byte* memory) const {
  if (!code_.labelled) return nullptr;
  const std::size_t labels = std::size_t(pitch_) * std::size_t(height_ + 2 * margin);
  return reinterpret_cast<std::uint8_t*>(memory + plane_bytes_ - labels) + margin * pitch_ + margin;
}

const std::uint8_t* ScalarPlanes::labels(int step) const {
  return labels_of(const_cast<ScalarPlanes*>(this)->memory_of_step(step).memory);
}

/// Frees what is needed no more.
void ScalarPlanes::use_shelf(const ShelfNumber& number) {
  if (shelf_ == number) return;
  if (shelf_) throw OtherBuild("GPs disagree on what a Renderer keeps");
  shelf_ = number;
  for (std::size_t k = 0; k < shelves_.size(); ++k)
    if ((number.live >> k & 1) == 0) empty(shelves_[k]);
}

/// Its memory serves the next shelf: giving it back and getting it anew costs more than filling it.
void ScalarPlanes::empty(Shelf& shelf) {
  std::move(shelf.memory.begin(), shelf.memory.end(), std::back_inserter(spare_));
  shelf = {};
}

/// Memory for planes_together() planes. What is not touched of it costs nothing, but in huge pages.
MappedMemory ScalarPlanes::memory_of_planes() {
  const std::size_t bytes = planes_together() * plane_bytes_;
  if (!spare_.empty() && spare_.back().get_deleter().bytes == bytes) {
    MappedMemory memory = std::move(spare_.back());
    spare_.pop_back();
    // Floats beyond the border that are read, although without weight, must be numbers.
    if (code_.floats) std::fill_n(memory.get(), bytes, std::byte{0});
    return memory;
  }
  spare_.clear();
  MappedMemory memory = map_memory(bytes);
  if (most_seen_) prefer_huge_pages(memory.get(), bytes);
  return memory;
}

ScalarPlanes::PlaneMemory ScalarPlanes::plane_on(Shelf& shelf, std::size_t plane) {
  if (plane >= shelf.slots.size()) shelf.slots.resize(plane + 1);
  Slot& slot = shelf.slots[plane];
  if (slot.holds.empty()) slot.holds.assign(blocks(), unknown);
  const std::size_t together = planes_together(), part = plane / together;
  if (part >= shelf.memory.size()) shelf.memory.resize(part + 1);
  auto& memory = shelf.memory[part];
  if (memory == nullptr) memory = memory_of_planes();
  return {memory.get() + plane % together * plane_bytes_, slot};
}

/// Makes what a plane holds speak of this frame's fillers: those that are other numbers now are unknown.
void ScalarPlanes::renew_fillers(Slot& slot) const {
  if (std::equal(fillers_.begin(), fillers_.end(), slot.fillers.begin(), same_bits)) return;
  std::array<std::uint8_t, 256> now;
  now.fill(unknown);
  now[voxels] = voxels;
  for (std::size_t k = 0; k < fillers_.size(); ++k) {
    const auto same = std::find_if(fillers_.begin(), fillers_.end(),
                                   [&](double filler) { return same_bits(filler, slot.fillers[k]); });
    if (same != fillers_.end()) now[k] = std::uint8_t(same - fillers_.begin());
  }
  slot.fillers = fillers_;
  for (std::uint8_t& held : slot.holds) held = now[held];
}

/// Differences at a border read one number beyond it, and that of the next block if the last has one voxel.
void ScalarPlanes::note_change(std::uint32_t block) {
  const int column = int(block) % columns_, row = int(block) / columns_;
  if (column == 0 || column >= columns_ - 2) changed_rows_.include(row * side, row * side + high(row));
  if (row == 0 || row >= rows_ - 2) changed_columns_.include(column * side, column * side + wide(column));
}

/// Calls `use` with each row of a block: where it begins in a plane, and its voxels.
void ScalarPlanes::for_rows(std::uint32_t block, auto&& use) const {
  for (int y = 0; y < high(int(block) / columns_); ++y)
    use(place_of(block) + y * pitch_, wide(int(block) % columns_));
}

/// Calls `change` with each row of a block's labels, where there are any.
void ScalarPlanes::for_labels(const PlaneMemory& place, std::uint32_t block, auto&& change) const {
  if (!code_.labelled) return;
  for_rows(block, [&, labels = labels_of(place.memory)](std::ptrdiff_t at, int count) {
    change(std::span(labels + at, std::size_t(count)));
  });
}

void ScalarPlanes::fill(const PlaneMemory& place, std::uint32_t block, std::uint8_t with) {
  Slot& slot = place.slot;
  if (slot.holds[block] == with) return;
  const bool stays = slot.holds[block] == voxels;
  for_labels(place, block, [stays](std::span<std::uint8_t> labels) {
    for (std::uint8_t& label : labels) label = stays ? label | unneeded : 0;
  });
  if (stays) return;
  slot.holds[block] = with;
  with_number([&](auto number) {
    if (with != BlockState::not_a_number || code_.floats)
      number = coded<decltype(number)>(code_, fillers_[with]);
    auto* const plane = origin<decltype(number)>(place.memory);
    for_rows(block, [&](std::ptrdiff_t at, int count) { std::fill_n(plane + at, count, number); });
  });
  note_change(block);
}

/// Fills the blocks of which a payload says nothing, as they may hold something else by now.
void ScalarPlanes::fill_unsaid(const PlaneMemory& place, const SheetPayload& payload, const PixelRect& seen) {
  const auto fill_some = [&](int row, int first, int end) {
    for (int column = first; column < end; ++column)
      fill(place, std::uint32_t(row * columns_ + column), payload.header.elsewhere);
  };
  for (int row = seen.y0; row < seen.y1; ++row) {
    const int said = row - payload.header.first_row;
    const BlockRow its =
        said >= 0 && said < int(payload.rows.size()) ? payload.rows[std::size_t(said)] : BlockRow{};
    fill_some(row, seen.x0, std::min<int>(seen.x1, its.first));
    fill_some(row, std::max<int>(seen.x0, its.end), seen.x1);
  }
}

template <class Number, class T>
void ScalarPlanes::put_blocks(const PlaneMemory& place, std::uint8_t voxels_are,
                              const SheetPayload& payload) {
  Slot& slot = place.slot;
  const std::byte* from = payload.voxels.data();
  payload.for_each_block([&](int column, int row, std::uint8_t byte) {
    const auto block = std::uint32_t(row * columns_ + column);
    if (byte < block_present) {
      fill(place, block, byte);
    } else if ((byte & block_kept) != 0) {
      if (slot.holds[block] != voxels)
        throw OtherBuild(fmt::format("block {} of plane {} counts as kept, but was never sent", block,
                                     payload.header.plane));
      for_labels(place, block, [](std::span<std::uint8_t> labels) {
        for (std::uint8_t& label : labels) label &= std::uint8_t(~unneeded);
      });
    } else {
      slot.holds[block] = voxels_are;
      note_change(block);
      from = put_block<Number, T>(place, block, (byte & block_labelled) != 0, from);
    }
  });
}

/// Returns the end of its bytes.
template <class Number, class T>
const std::byte* ScalarPlanes::put_block(const PlaneMemory& place, std::uint32_t block, bool labelled,
                                         const std::byte* from) const {
  const int across = wide(int(block) % columns_);
  Number* voxel = origin<Number>(place.memory) + place_of(block);
  const auto place_rows = [&](auto count) {
    for (int y = 0; y < high(int(block) / columns_); ++y, from += std::size_t(count) * sizeof(T))
      convert<Number, T>(from, count, code_, voxel + y * pitch_);
  };
  if (across == side)
    place_rows(std::integral_constant<int, side>());
  else
    place_rows(across);
  if (labelled && !code_.labelled) throw OtherBuild("a block has labels in a frame without tints");
  for_labels(place, block, [&](std::span<std::uint8_t> labels) {
    if (labelled)
      std::memcpy(labels.data(), from, labels.size()), from += labels.size();
    else
      std::ranges::fill(labels, std::uint8_t{0});
  });
  return from;
}

void ScalarPlanes::extrapolate_border(auto* p) {
  const int next = width_ > 1 ? 1 : 0;
  for (int y = changed_rows_.first; y < changed_rows_.end; ++y) {
    auto* const row = p + y * pitch_;
    row[-1] = beyond(row[0], row[next]);
    row[width_] = beyond(row[width_ - 1], row[width_ - 1 - next]);
  }
  const std::ptrdiff_t down = height_ > 1 ? pitch_ : 0, last = (height_ - 1) * pitch_;
  const PixelRun& x = changed_columns_;
  if (x.empty()) return;
  // The corners follow the borders beside them.
  const int from = x.first == 0 ? -1 : x.first, to = x.end >= width_ - 1 ? width_ : x.end - 1;
  for (int at = from; at <= to; ++at) {
    p[at - pitch_] = beyond(p[at], p[at + down]);
    p[at + last + pitch_] = beyond(p[at + last], p[at + last - down]);
  }
}

void ScalarPlanes::put(const PlaneMemory& place, std::uint8_t voxels_are, const SheetPayload& payload,
                       ScalarType type, const PixelRect& seen) {
  changed_columns_ = changed_rows_ = {};
  fill_unsaid(place, payload, seen);
  with_number([&](auto number) {
    visit_type(type,
               [&](auto zero) { put_blocks<decltype(number), decltype(zero)>(place, voxels_are, payload); });
    extrapolate_border(origin<decltype(number)>(place.memory));
  });
}

void ScalarPlanes::place(int step, const SheetPayload& payload, ScalarType type, const PixelRect& seen) {
  most_seen_ = 4 * std::int64_t(seen.width()) * seen.height() > blocks();
  plane_of_step_.resize(std::max(plane_of_step_.size(), std::size_t(step + 2)), no_plane);
  plane_of_step_[std::size_t(step + 1)] = payload.header.plane;
  if (!keep(payload, type, seen)) put(memory_of_step(step), unknown, payload, type, seen);
}

bool ScalarPlanes::keep(const SheetPayload& payload, ScalarType type, const PixelRect& seen) {
  use_shelf(payload.header.shelf);
  if (payload.header.plane == no_plane) return false;
  Shelf& shelf = shelves_[shelf_->shelf];
  if (shelf.generation != shelf_->generation || shelf.width != width_ || shelf.height != height_ ||
      shelf.code != code_) {  // it is used anew
    empty(shelf);
    shelf = {shelf_->generation, width_, height_, code_, {}, {}};
  }
  const PlaneMemory place = plane_on(shelf, payload.header.plane);
  renew_fillers(place.slot);
  put(place, voxels, payload, type, seen);
  return true;
}

void ScalarPlanes::extrapolate(int step, int a, int b, const PixelRect& seen) {
  const PlaneMemory to = memory_of_step(step), at_a = memory_of_step(a), at_b = memory_of_step(b);
  with_number([&](auto number) {
    using Number = decltype(number);
    auto* const out = origin<Number>(to.memory);
    const auto *one = origin<Number>(at_a.memory), *other = origin<Number>(at_b.memory);
    const auto extrapolate_row = [=](std::ptrdiff_t first, std::ptrdiff_t numbers) {
      for (std::ptrdiff_t at = first; at < first + numbers; ++at)
        out[at] = static_cast<Number>(2 * one[at] - other[at]);
    };
    for (int row = seen.y0; row < seen.y1; ++row)
      for (int column = seen.x0; column < seen.x1; ++column) {
        const auto block = std::uint32_t(row * columns_ + column);
        to.slot.holds[block] = unknown;
        for_rows(block, extrapolate_row);
      }
    for (const int y : {-1, height_}) extrapolate_row(y * pitch_ - 1, width_ + 2);
    for (int y = 0; y < height_; ++y)
      for (const int x : {-1, width_}) extrapolate_row(y * pitch_ + x, 1);
  });
}

}  // namespace ringsplat
