#pragma once
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "classify/classifier.hpp"
#include "classify/phong.hpp"
#include "frame/frame_geometry.hpp"
#include "raster/opaque_tiles.hpp"
#include "splat/splat.hpp"
#include "splat_engine/splat_frame.hpp"

namespace ringsplat {

/// The tables that turn one frame's voxels into colours. Safe to use from several threads.
class FrameShading {
 public:
  /// Both must outlive it.
  FrameShading(const Shown& shown, const FrameGeometry& geometry)
      : shown_(shown),
        geometry_(geometry),
        classifier_(
            shown.transfer_function, geometry.grid.type,
            shown.opacity_correction ? geometry.traversal.slice_distance : double(shown.reduction.factor)) {}

  const Classifier& classifier() const { return classifier_; }
  bool lit() const { return shown_.shading == Shading::phong; }

  /// Built on first use: a frame with nothing visible needs none.
  const PhongTable& phong() const {
    std::call_once(once_, [this] {
      const ViewTransform& view = geometry_.view;
      phong_.emplace(shown_.material,
                     view.right * shown_.light.x + view.up * shown_.light.y + view.to_viewer * shown_.light.z,
                     view.to_viewer);
    });
    return *phong_;
  }

 private:
  const Shown& shown_;
  const FrameGeometry& geometry_;
  Classifier classifier_;
  mutable std::once_flag once_;
  mutable std::optional<PhongTable> phong_;
};

/// State that the bands of a frame's slices share; constant while they work.
struct EncoderFrame {
  /// `splat_frame` must outlive it.
  explicit EncoderFrame(const SplatFrame& splat_frame)
      : frame(splat_frame),
        geometry(frame.geometry),
        shading(frame.shown, geometry),
        reach(kernel_reach(frame.footprint)),
        stride(pass_stride(frame.splats.kernel_radius)) {
    for (int region = 0; region < geometry.regions.count(); ++region) {
      rects.push_back(geometry.regions.rect(region));
      opaque.emplace_back(rects.back().width(), rects.back().height());
    }
  }

  /// News from a Renderer's Painter::opaque_news. Throws RunError when the bytes are no such news.
  void take_opaque_news(std::span<const std::byte> news) { read_opaque_news(news, opaque); }

  const SplatFrame& frame;
  const FrameGeometry& geometry;
  FrameShading shading;
  KernelReach reach;
  int stride;                       ///< between voxels of one pass
  std::vector<PixelRect> rects;     ///< by region
  std::vector<OpaqueTiles> opaque;  ///< by region
};

}  // namespace ringsplat
