#include "splat/frame_kernel.hpp"

#include "splat/footprint_table.hpp"
#include "splat/stencil.hpp"

namespace ringsplat {
namespace {

KernelWeights choose_weights(const Footprint& footprint, const KernelOptions& options) {
  if (options.method == KernelMethod::texture)
    return TabledWeights{std::make_shared<FootprintTable>(make_footprint_table(footprint, options.phases))};
  if (options.qee_bits > 0) return FixedPointWeights{options.qee_bits};
  if (has_stencil(footprint)) return StencilWeights{};
  return RowWeights{};
}

}  // namespace

FrameKernel make_frame_kernel(const Footprint& footprint, const ViewTransform& view, Axis axis,
                              const KernelOptions& options) {
  check(options, footprint);
  FrameKernel kernel{footprint, choose_weights(footprint, options), {}};
  if (options.normalisation == Normalisation::exact) {
    const auto plane = in_plane(axis);
    kernel.lattice_sum = std::make_shared<LatticeSum>(
        footprint, glm::dmat2(glm::dvec2(view.linear[plane.u]), glm::dvec2(view.linear[plane.v])));
  }
  return kernel;
}

}  // namespace ringsplat
