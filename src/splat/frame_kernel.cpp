#include "splat/frame_kernel.hpp"

#include "splat/footprint_table.hpp"

namespace ringsplat {

FrameKernel make_frame_kernel(const Footprint& footprint, const ViewTransform& view, Axis axis,
                              const KernelOptions& options) {
  check(options, footprint);
  FrameKernel kernel{footprint, options.qee_bits, {}, {}};
  if (options.method == KernelMethod::texture)
    kernel.table = std::make_shared<FootprintTable>(make_footprint_table(footprint, options.phases));
  if (options.normalisation == Normalisation::exact) {
    const auto plane = in_plane(axis);
    kernel.lattice_sum = std::make_shared<LatticeSum>(
        footprint, glm::dmat2(glm::dvec2(view.linear[plane.u]), glm::dvec2(view.linear[plane.v])));
  }
  return kernel;
}

}  // namespace ringsplat
