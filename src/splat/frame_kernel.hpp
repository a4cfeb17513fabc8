#pragma once
#include <memory>

#include "ringsplat/splat/kernel_options.hpp"
#include "splat/lattice_sum.hpp"

namespace ringsplat {

struct FootprintTable;

/// How a frame's splats are drawn: the footprint, and what the options add to it. Made once a frame and
/// shared by a Renderer's regions.
struct FrameKernel {
  Footprint footprint;
  int qee_bits = 0;                               ///< 0: float32
  std::shared_ptr<const FootprintTable> table;    ///< of textures, else empty
  std::shared_ptr<const LatticeSum> lattice_sum;  ///< of the exact normalisation, else empty
};

/// `axis`: of the slices. Throws InputError as check(options, footprint) does.
FrameKernel make_frame_kernel(const Footprint& footprint, const ViewTransform& view, Axis axis,
                              const KernelOptions& options);

}  // namespace ringsplat
