#pragma once
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "raster/region_image.hpp"
#include "splat/splat.hpp"
#include "splat_engine/splat_engine.hpp"

namespace ringsplat {

/// One region's part of a payload.
struct PayloadPart {
  int region = 0;
  std::span<const std::byte> bytes;
};

/// Splits a payload into its regions' parts, and sums a part's splats before it composites them.
class PayloadReader {
 public:
  virtual ~PayloadReader() = default;
  /// The parts of a payload, one for each region, in ascending order. Checks the whole payload, so that a bad
  /// message leaves no half-drawn slice. Throws RunError unless it is a payload for regions whose `owned` is
  /// true.
  virtual std::vector<PayloadPart> parts(std::span<const std::byte> body,
                                         const std::function<bool(int region)>& owned) const = 0;
  /// Goes to the first splat of a part that parts() returned, for its region's image. The payload must stay
  /// valid until more() is false.
  virtual void begin(int slice, const PayloadPart& part, RegionImage& image) = 0;
  /// True while the part has splats to draw.
  virtual bool more() = 0;
  /// Draws at least one and about `most` of the part's next splats.
  virtual DrawCounts draw(std::uint32_t most) = 0;
  /// Puts what was drawn behind the image (SplatSum::composite).
  virtual std::uint64_t composite() = 0;
};

/// A reader for a frame's form. The frame must outlive it.
std::unique_ptr<PayloadReader> make_payload_reader(const SplatFrame& frame);

}  // namespace ringsplat
