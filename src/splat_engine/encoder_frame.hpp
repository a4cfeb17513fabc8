#pragma once
#include <span>
#include <vector>

#include "frame/frame_shading.hpp"
#include "raster/opaque_cover.hpp"
#include "splat/encode.hpp"
#include "splat_engine/splat_frame.hpp"

namespace ringsplat {

/// State that the bands of a frame's slices share; constant while they work.
struct EncoderFrame {
  /// `splat_frame` must outlive it.
  explicit EncoderFrame(const SplatFrame& splat_frame);

  /// News from a Renderer's Painter::opaque_news. Throws RunError when the bytes are no such news.
  void take_opaque_news(std::span<const std::byte> news);

  const SplatFrame& frame;
  const FrameGeometry& geometry;
  FrameShading shading;
  KernelReach reach;
  int stride;                       ///< between voxels of one pass
  std::vector<PixelRect> rects;     ///< by region
  std::vector<OpaqueTiles> opaque;  ///< by region
  std::vector<OpaqueCover> covers;  ///< made of `opaque`, by region
};

}  // namespace ringsplat
