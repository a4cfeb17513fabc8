#pragma once
#include <memory>
#include <variant>

#include "ringsplat/splat/kernel_options.hpp"
#include "splat/lattice_sum.hpp"

namespace ringsplat {

struct FootprintTable;

/// Q² computed in float32, with a stencil of pixel blocks round each anchor.
struct StencilWeights {};
/// Q² computed in float32, row by row, for windows too large for a stencil.
struct RowWeights {};
/// Q² computed in fixed point with so many bits of Q.
struct FixedPointWeights {
  int bits;
};
/// Q² looked up.
struct TabledWeights {
  std::shared_ptr<const FootprintTable> table;  ///< never null
};
using KernelWeights = std::variant<StencilWeights, RowWeights, FixedPointWeights, TabledWeights>;

/// How a frame's splats are drawn. Made once a frame, where the options are resolved, and shared by all
/// threads.
struct FrameKernel {
  Footprint footprint;
  KernelWeights weights;
  std::shared_ptr<const LatticeSum> lattice_sum;  ///< null unless the normalisation is exact
};

/// `axis`: of the slices. Throws InputError as check(options, footprint) does.
FrameKernel make_frame_kernel(const Footprint& footprint, const ViewTransform& view, Axis axis,
                              const KernelOptions& options);

}  // namespace ringsplat
