#pragma once
#include <functional>
#include <memory>

#include "protocol/engine.hpp"
#include "ringsplat/base/image.hpp"
#include "ringsplat/base/thread_team.hpp"
#include "ringsplat/net/layout.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/slice_store.hpp"

namespace ringsplat {

class EmptySpace;

/// A frame as the nodes of a rank share it: what was announced, and what follows from it.
struct SplatFrame {
  FrameSpec spec;
  FrameGeometry geometry;
  FramePlan plan;
};
std::shared_ptr<const SplatFrame> make_splat_frame(const FrameSpec& spec, const Grid& grid, int gps, int renderers);

struct EncoderOptions {
  bool skip_empty = true;  ///< slices that the transfer function makes transparent have no part in a frame
  bool timed = false;      ///< seconds by stage are measured
};

/// A GP's encoder for one frame. `store`, `empty_space` and `threads` must outlive it; `empty_space` is kept from
/// frame to frame, one for each level of the store. The payloads are the same bytes with any number of threads.
/// Throws RunError when the slices that the frame traverses were not loaded.
std::unique_ptr<Encoder> make_splat_encoder(std::shared_ptr<const SplatFrame> frame, int renderers,
                                            const SliceStore& store, EmptySpace& empty_space, ThreadTeam& threads,
                                            const EncoderOptions& options = {});

/// A Renderer's painter, which keeps its buffers from frame to frame.
class FramePainter : public Painter {
 public:
  /// Forgets the last image.
  virtual void begin_frame(std::shared_ptr<const SplatFrame> frame) = 0;
};
/// `threads` must outlive it; the image has the same bits with any number of them.
std::unique_ptr<FramePainter> make_splat_painter(int renderer, int renderers, ThreadTeam& threads);

/// Takes a frame's picture once its canvas is finished.
using TakePicture = std::function<void(std::int64_t frame, Image&& picture)>;

/// Tiles into the picture, by a warp where the image plane is not the screen.
std::unique_ptr<Canvas> make_picture_canvas(std::shared_ptr<const SplatFrame> frame, TakePicture take);

/// The paper's engine for one rank: `slices` are those of its GP, if it hosts one; `take` is called on the frame
/// buffer's rank. `threads` share a node's work.
std::unique_ptr<Engine> make_splat_engine(const Grid& grid, const Layout& layout, SliceStore slices, int threads,
                                          const EncoderOptions& options, TakePicture take);

}  // namespace ringsplat
