#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "sheet_engine/sheet_payload.hpp"
#include "sheet_engine/slice_blocks.hpp"
#include "sheet_engine/table_axis.hpp"

namespace ringsplat {

/// What stands for the voxels of blocks that were left out: numbers that are as transparent as they are, by
/// BlockState::transparent.
using Fillers = std::array<double, BlockState::not_a_number + 1>;
Fillers make_fillers(const TransparentValues& transparent, ScalarType type, double low, double high);

/// The slices of a Renderer's frame that are still needed, as planes of 16-bit numbers or floats. Round each
/// plane lie its linear extrapolations, so that central differences at the border are one-sided.
class ScalarPlanes {
 public:
  static constexpr int margin = 8;  ///< numbers that can be read on each side of a plane

  /// For slices of one frame; `slots`: how many are kept. Planes keep what they hold only while all arguments
  /// are as before.
  void begin_frame(int width, int height, int slots, const PlaneCode& code, const Fillers& fillers);
  int slots() const { return slots_; }
  std::ptrdiff_t pitch() const { return pitch_; }

  /// Puts a slice into the place of the step `slots` before. `step` may be -1.
  void place(int step, const SheetPayload& payload, ScalarType type);
  /// Puts 2a - b there.
  void extrapolate(int step, int a, int b);
  /// Voxel (0, 0).
  const void* plane(int step) const;

 private:
  static constexpr std::uint8_t unknown = 0xff;

  template <class Number>
  Number* origin(int step);
  template <class Number>
  void place_as(int step, const SheetPayload& payload, ScalarType type);
  template <class Number>
  void place_blocks(int step, const SheetPayload& payload, ScalarType type);
  template <class Number>
  void fill(Number* voxel, int column, int row, std::uint8_t with, std::uint8_t& holds);
  template <class Number>
  void extrapolate_border(int step);
  std::size_t slot_of(int step) const { return std::size_t((step + 1) % slots_); }

  int width_ = 0, height_ = 0, slots_ = 0;
  int columns_ = 0, rows_ = 0;  ///< of blocks
  std::ptrdiff_t pitch_ = 0;
  PlaneCode code_;
  Fillers fillers_{};
  std::size_t plane_bytes_ = 0;
  std::vector<std::byte> memory_;
  std::vector<std::uint8_t> holds_;  ///< by slot and block: the filler in it; unknown: something else
};

/// Bytes of one plane.
std::size_t plane_bytes(int width, int height, bool floats);

}  // namespace ringsplat
