#pragma once
#include <cstddef>
#include <span>

#include "raster/opaque_tiles.hpp"
#include "raster/slice_buffer.hpp"
#include "screen/regions.hpp"

namespace ringsplat {

/// One region's composited slices: premultiplied colour and opacity of each pixel, and which tiles are
/// opaque.
///
/// A pixel whose transmittance has fallen below the frame's threshold takes nothing more. That is decided
/// pixel by pixel from the slices before, so anyone who knows of such pixels may leave out what lies wholly
/// behind them, at any time, and the image keeps its bits.
///
/// The memory is allocated when the first pixels come, and kept from frame to frame.
class RegionImage {
 public:
  /// `rect`: the region's pixels in the image plane, at least one.
  explicit RegionImage(const PixelRect& rect)
      : rect_(rect),
        row_floats_(in_whole_blocks(rect.width()) * floats_a_pixel),
        tiles_(rect.width(), rect.height()) {}

  /// Forgets the last frame's image. `opaque_threshold`: transmittances below it count as 0; 0: none does.
  void begin_frame(float opaque_threshold) {
    opaque_threshold_ = opaque_threshold;
    touched_ = false;
    tiles_.clear();
    slices_ = 0;
  }

  const PixelRect& rect() const { return rect_; }
  float opaque_threshold() const { return opaque_threshold_; }
  /// False when pixels() was not called in this frame: the region is transparent.
  bool touched() const { return touched_; }
  /// RGBA of pixel (0, 0), to composite into. Rows are whole pixel blocks and 64-byte aligned. The frame's
  /// first call makes all pixels transparent; later ones change nothing, so that threads may share them.
  float* pixels();
  std::ptrdiff_t row_floats() const { return row_floats_; }

  /// Call after slices were composited. Every few slices looks for opaque tiles.
  void slices_composited(int slices = 1);
  /// Tiles that take nothing more in this frame, as slices_composited() last found them.
  const OpaqueTiles& opaque_tiles() const { return tiles_; }

  /// Writes width × height premultiplied RGBA floats, rows from the top.
  void read_tile(std::span<float> rgba) const;

 private:
  bool is_opaque(int column, int row) const;

  PixelRect rect_;
  std::ptrdiff_t row_floats_;
  float opaque_threshold_ = 0;
  AlignedFloats pixels_;
  bool touched_ = false;
  OpaqueTiles tiles_;
  int slices_ = 0;  ///< composited in this frame
};

}  // namespace ringsplat
