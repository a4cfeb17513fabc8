#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "raster/slice_buffer.hpp"
#include "screen/pixel_window.hpp"
#include "screen/regions.hpp"

namespace ringsplat {

/// The pixels of a slice that a Renderer composites: in each row of a region the run from the first to the
/// last pixel block that a kernel may reach (as SplatSum does).
class PixelRuns {
 public:
  PixelRuns() = default;
  /// `rects`: by region, its pixels; they must outlive it.
  explicit PixelRuns(std::span<const PixelRect> rects);
  /// Adds the window of a kernel, of which only what lies in the region counts.
  void include(int region, const PixelWindow& window);
  /// Adds another's runs of the region, and empties them there.
  void join(PixelRuns& other, int region);
  /// The region's pixels in runs; forgets them.
  std::uint64_t take(int region);

 private:
  std::span<const PixelRect> rects_;
  std::vector<std::vector<PixelRun>> rows_;  ///< by region and row; none where nothing was added
};

}  // namespace ringsplat
