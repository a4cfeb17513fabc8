#pragma once
#include <memory>

#include "splat/lattice_sum.hpp"

namespace ringsplat {

/// How a frame's splats are drawn. Made once a frame and shared by all threads.
struct FrameKernel {
  Footprint footprint;
  std::shared_ptr<const LatticeSum> lattice_sum;  ///< null unless the normalisation is exact
};

}  // namespace ringsplat
