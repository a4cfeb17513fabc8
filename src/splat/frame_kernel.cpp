#include "splat/frame_kernel.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "ringsplat/base/error.hpp"
#include "splat/footprint.hpp"
#include "splat/splat_sum.hpp"

namespace ringsplat {

std::string name(KernelMethod method) { return method == KernelMethod::qee ? "qee" : "texture"; }

std::string name(Normalisation normalisation) {
  constexpr const char* names[] = {"none", "constant", "exact"};
  return names[static_cast<int>(normalisation)];
}

void check(const KernelOptions& options, double radius) {
  if (options.phases < 1 || options.phases > 16)
    throw InputError(fmt::format("a table of {} sub-pixel phases is not within 1 to 16", options.phases),
                     "for instance --phases 4");
  if (options.qee_bits != 0 && (options.qee_bits < 2 || options.qee_bits > 16))
    throw InputError(fmt::format("Q of {} bits is not within 2 to 16", options.qee_bits),
                     "--qee-bits 10 is what Pixel-Planes 5 had, --qee-bits 0 is float32");
  if (options.qee_bits != 0 && options.method == KernelMethod::texture)
    throw InputError("--qee-bits has no effect with --kernel texture, which computes no Q",
                     "use --kernel qee or leave out --qee-bits");
  if (options.normalisation == Normalisation::exact && !(radius >= 1))
    throw InputError(
        fmt::format("kernels of radius {} leave gaps, whose weights cannot be normalised", radius),
        "use --radius 1 or more, or --normalisation constant");
}

void check(const KernelOptions& options, const Footprint& footprint) {
  const bool texture = options.method == KernelMethod::texture;
  if (!texture && options.qee_bits == 0) return;
  const double wide = 2 * std::max(footprint.half.x, footprint.half.y);
  const double widest = texture ? 2000 : 8000;
  if (!(wide <= widest))
    throw InputError(
        fmt::format("a voxel's kernel would be {:.3g} pixels wide, more than the {} that {} holds", wide,
                    widest, texture ? "a texture" : "fixed point"),
        texture ? "use --kernel qee or a smaller --zoom" : "use --qee-bits 0 or a smaller --zoom");
}

FrameKernel make_frame_kernel(const Footprint& footprint, const ViewTransform& view, Axis axis,
                              const KernelOptions& options) {
  check(options, footprint);
  FrameKernel kernel{footprint, RowWeights{}, {}};
  if (options.method == KernelMethod::texture)
    kernel.weights =
        TabledWeights{std::make_shared<FootprintTable>(make_footprint_table(footprint, options.phases))};
  else if (options.qee_bits > 0)
    kernel.weights = FixedPointWeights{options.qee_bits};
  else if (has_stencil(footprint))
    kernel.weights = StencilWeights{};
  if (options.normalisation == Normalisation::exact) {
    const auto plane = in_plane(axis);
    kernel.lattice_sum = std::make_shared<LatticeSum>(
        footprint, glm::dmat2(glm::dvec2(view.linear[plane.u]), glm::dvec2(view.linear[plane.v])));
  }
  return kernel;
}

}  // namespace ringsplat
