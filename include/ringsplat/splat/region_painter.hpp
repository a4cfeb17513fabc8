#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "ringsplat/splat/splat.hpp"

namespace ringsplat {

struct DrawCounts {
  std::uint64_t drawn = 0;    ///< splats that reached at least one pixel centre of the region with Q > 0
  std::uint64_t clipped = 0;  ///< splats that reached none
};

/// One region's slice buffer and image (Westover 1989; Neumann 1992, section 2.3).
///
/// The slice buffer sums the splats of one slice; composite() puts it behind the image and empties it.
/// Colours are premultiplied; the image keeps colour and transmittance. A pixel's sum runs in the order of
/// the splats given, with the same operations whatever the vector width, so its bits do not depend on the
/// processor, the region size or the other splats.
class RegionPainter {
 public:
  /// Region of width × height pixels whose corner is screen pixel (x0, y0). No pixels are allocated before
  /// the first splat. Throws InputError for a size below 1.
  RegionPainter(int x0, int y0, int width, int height);
  ~RegionPainter();
  RegionPainter(RegionPainter&&) noexcept;
  RegionPainter& operator=(RegionPainter&&) noexcept;

  /// Forgets the last frame's image and takes the frame's footprint.
  void begin_frame(const Footprint& footprint);
  /// Sums splats into the slice buffer. `bytes` is count × sizeof(Splat), any alignment.
  /// Splats with a NaN or a coefficient that no footprint can have are counted as clipped.
  DrawCounts draw(std::int32_t base_x, std::int32_t base_y, std::span<const std::byte> splats);
  /// Puts the slice behind the image: C += T c, T *= 1 − a, with a and c clamped to [0, 1] and [0, a];
  /// empties the slice buffer. Costs nothing when no splat was drawn since the last call.
  void composite();
  /// False when nothing was drawn since begin_frame: the region is empty.
  bool touched() const;
  /// Writes width × height premultiplied RGBA floats (alpha = 1 − T), rows from the top; transparent when
  /// untouched. Throws InputError when `rgba` has another size.
  void read_tile(std::span<float> rgba) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The vector instruction set in use ("AVX3", "AVX2", "SSE4", "NEON", "SCALAR" ...), for the log.
const char* vector_target();

}  // namespace ringsplat
