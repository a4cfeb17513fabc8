#pragma once
#include <functional>
#include <memory>
#include <span>

#include "ringsplat/node/frame_spec.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

/// Splats of one region with the base of their anchors.
struct SplatChunk {
  int region = 0;
  std::int32_t base_x = 0, base_y = 0;
  std::span<const std::byte> splats;  ///< of sizeof(Splat) bytes each, any alignment
  std::uint64_t off_screen = 0;       ///< further splats, so far from the region that they cannot reach it
};

/// Takes a payload apart into splats, region by region in ascending order.
class PayloadReader {
 public:
  virtual ~PayloadReader() = default;
  /// `body` must stay valid until next() has returned false. Looks at all of it before anything is drawn, so that a bad
  /// message leaves no half-drawn slice; throws RunError when it is no payload for the regions that `owned` is true of.
  virtual void begin(int slice, std::span<const std::byte> body, const std::function<bool(int region)>& owned) = 0;
  /// The next at most `most` splats; false when there are no more.
  virtual bool next(std::uint32_t most, SplatChunk& chunk) = 0;
};

/// For payloads of a frame's form and precision. `geometry` must outlive it.
std::unique_ptr<PayloadReader> make_word_reader();
std::unique_ptr<PayloadReader> make_run_reader(const FrameSpec& spec, const FrameGeometry& geometry);

}  // namespace ringsplat
