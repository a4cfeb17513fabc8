#pragma once
#include <span>
#include <vector>

#include "frame/frame_shading.hpp"
#include "raster/opaque_cover.hpp"
#include "splat/encode.hpp"

namespace ringsplat {

/// What the bands of one frame's slices share. It does not change while they work.
struct EncoderFrame {
  /// Both must outlive it.
  EncoderFrame(const FrameSpec& frame_spec, const FrameGeometry& frame_geometry);

  /// News from a Renderer's Painter::opaque_news. Throws RunError when the bytes are no such news.
  void take_opaque_news(std::span<const std::byte> news);

  const FrameSpec& spec;
  const FrameGeometry& geometry;
  FrameShading shading;
  KernelReach reach;
  int stride;                       ///< of passes
  std::vector<PixelRect> rects;     ///< by region
  std::vector<OpaqueTiles> opaque;  ///< by region
  std::vector<OpaqueCover> covers;  ///< of them
};

}  // namespace ringsplat
