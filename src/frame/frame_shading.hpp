#pragma once
#include <mutex>
#include <optional>

#include "classify/classifier.hpp"
#include "classify/phong.hpp"
#include "frame/frame_geometry.hpp"

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

}  // namespace ringsplat
