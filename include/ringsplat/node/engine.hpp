#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "ringsplat/base/bytes.hpp"
#include "ringsplat/base/thread_team.hpp"
#include "ringsplat/node/frame_spec.hpp"
#include "ringsplat/node/trace.hpp"
#include "ringsplat/volume/slice_store.hpp"

namespace ringsplat {

/// The seam between the frame loop and the way slices become payloads and payloads become pixels: an Encoder
/// on each GP, a Painter on each Renderer. The frame loop knows neither a voxel nor a colour.
struct EncodedSlice {
  std::vector<Bytes>
      payloads;  ///< one for each Renderer, made in Message::body_buffer(); empty: nothing to draw
  std::vector<std::uint32_t> splats;  ///< in each payload
  std::vector<std::uint32_t>
      passes;  ///< of each payload: non-empty (region, pass) pairs (Neumann 1992, Fig. 3)
  std::uint64_t visible_voxels = 0;
  std::uint64_t voxels_outside = 0;  ///< not looked at, because they lie outside the image
  std::uint64_t voxels = 0;          ///< of the slice, transparent ones too
};

class Encoder {
 public:
  virtual ~Encoder() = default;
  virtual void begin(const SliceView& slice) = 0;
  /// News from a Renderer's Painter::opaque_news: what lies wholly under opaque pixels need not be sent any
  /// more. Throws RunError when the bytes are no such news.
  virtual void take_opaque_news(std::span<const std::byte> news) = 0;
  /// A bounded piece of the slice (well under a millisecond of each thread); true once the slice is complete.
  virtual bool work() = 0;
  virtual EncodedSlice finish() = 0;
  /// From now on adds to `*stages` what of the time classifying and shading take; null, as at first: measures
  /// nothing.
  virtual void time_stages(StageSeconds* stages) = 0;
};

struct PaintCounts {
  std::uint64_t drawn = 0, clipped = 0, hidden = 0;
};

class Painter {
 public:
  virtual ~Painter() = default;
  virtual void begin_frame(const FrameSpec& spec, const FrameGeometry& geometry) = 0;
  /// Takes the payload of traversal step `step`; `body` stays valid until work() has returned true.
  /// Throws RunError when the bytes are no payload for this Renderer.
  virtual void begin(int step, std::span<const std::byte> body) = 0;
  /// A bounded piece of the slice for each thread; true once it is drawn and composited.
  virtual bool work() = 0;
  /// Appends, for GP `gp`, which parts of this Renderer's regions have become opaque since it was last told
  /// in this frame.
  virtual void opaque_news(int gp, Bytes& news) = 0;
  virtual PaintCounts counts() const = 0;        ///< of this frame so far
  virtual double composite_seconds() const = 0;  ///< of this frame so far, by the clock on the wall

  /// Calls `deliver(region, rgba)` for each region that is not empty: region pixels, row by row,
  /// premultiplied RGBA, in a Message::body_buffer().
  virtual void finish(const std::function<void(int region, Bytes rgba)>& deliver) = 0;
};

/// What an Encoder keeps from frame to frame: where a GP's slices are empty.
class EmptySpace;

/// `spec`, `geometry`, `empty_space` and `threads` must outlive the encoder. The payloads are the same bytes
/// with any number of threads.
std::unique_ptr<Encoder> make_encoder(const FrameSpec& spec, const FrameGeometry& geometry, int renderers,
                                      EmptySpace& empty_space, ThreadTeam& threads);

/// A Renderer's painter; begin_frame() forgets the last image and keeps its buffers. `threads` must outlive
/// it; the image has the same bits with any number of them.
std::unique_ptr<Painter> make_painter(int renderer, int renderers, ThreadTeam& threads);

}  // namespace ringsplat
