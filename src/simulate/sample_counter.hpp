#pragma once
#include <cstdint>
#include <vector>

#include "sheet_engine/block_windows.hpp"

namespace ringsplat {

/// Counts the samples that a slice's visible blocks take each Renderer, as SheetPainter does when it paints
/// them: the pixels of the tiles that they touch, for every slab that begins at the slice.
class SampleCounter {
 public:
  /// `finer`: as of BlockWindows.
  explicit SampleCounter(const SheetFrame& frame, int finer = 1);

  /// Begins the slice of a step.
  void begin(int step, int renderers);
  /// Adds a block with visible cells.
  void add(int column, int row);
  /// By Renderer.
  const std::vector<std::uint64_t>& samples() const { return samples_; }

 private:
  struct Region {
    PixelRect rect;
    std::size_t first_tile = 0;
    int columns = 0;  ///< of tiles
  };
  void mark(const PixelWindow& pixels, std::vector<bool>& marked);

  const SheetFrame& frame_;
  SlabWindows windows_;
  std::vector<Region> regions_;
  int step_ = 0;
  std::vector<bool> before_,
      behind_;  ///< by tile: marked in the slab before the first slice, behind this one
  std::vector<std::uint64_t> samples_;
};

}  // namespace ringsplat
