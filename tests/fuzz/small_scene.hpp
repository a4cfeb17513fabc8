#pragma once
#include <memory>

#include "base/thread_team.hpp"
#include "classify/empty_space.hpp"
#include "frame/frame_geometry.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "splat_engine/splat_engine.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat::fuzz {

/// 12 x 10 x 9 voxels of a byte.
Grid small_grid();
/// A picture of the small grid, 48 x 40 pixels in regions of 16. The bits of `choice` select the payload's
/// form, the image plane and how kernels are drawn: all that decoding payloads depends on.
FrameSpec small_frame(unsigned choice);
inline constexpr unsigned frame_choices = 8;  ///< number of different choices
/// All of a grid's slices, with values and normals of every kind.
SliceStore patterned_slices(const Grid& grid);

/// One GP and one of two Renderers of a frame.
class SmallRun {
 public:
  SmallRun(const FrameSpec& spec, const Grid& grid);
  const FrameGeometry& geometry() const { return frame_->geometry; }
  Encoder& encoder() { return *encoder_; }
  Painter& painter() { return *painter_; }
  /// Encodes a step; returns the part for the Renderer.
  Bytes encode(int step);
  void draw(int step, std::span<const std::byte> payload);
  /// Throws std::logic_error when a tile has a number that no picture has.
  void finish();

 private:
  std::shared_ptr<const SplatFrame> frame_;
  SliceStore slices_;
  EmptySpace empty_space_;
  ThreadTeam alone_;
  std::unique_ptr<Encoder> encoder_;
  std::unique_ptr<FramePainter<SplatFrame>> painter_;
};
inline constexpr int small_renderers = 2;

}  // namespace ringsplat::fuzz
