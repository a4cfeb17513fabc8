#pragma once
#include <mutex>
#include <optional>

#include "ringsplat/classify/classifier.hpp"
#include "ringsplat/classify/phong.hpp"
#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat {

/// The tables that turn one frame's voxels into colours. Safe to use from several threads.
class FrameShading {
 public:
  /// Both must outlive it.
  FrameShading(const FrameSpec& spec, const FrameGeometry& geometry)
      : spec_(spec),
        geometry_(geometry),
        classifier_(
            spec.transfer_function, geometry.grid.type,
            spec.opacity_correction ? geometry.traversal.slice_distance : double(spec.reduction.factor)) {}

  const Classifier& classifier() const { return classifier_; }
  bool lit() const { return spec_.shading == Shading::phong; }

  /// Made when first asked for: a frame with nothing visible does without.
  const PhongTable& phong() const {
    std::call_once(once_, [this] {
      const ViewTransform& view = geometry_.view;
      phong_.emplace(spec_.material,
                     view.right * spec_.light.x + view.up * spec_.light.y + view.to_viewer * spec_.light.z,
                     view.to_viewer);
    });
    return *phong_;
  }

 private:
  const FrameSpec& spec_;
  const FrameGeometry& geometry_;
  Classifier classifier_;
  mutable std::once_flag once_;
  mutable std::optional<PhongTable> phong_;
};

}  // namespace ringsplat
