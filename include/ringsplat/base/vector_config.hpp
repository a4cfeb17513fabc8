#pragma once
// Included before Highway. The kernels keep arrays of vectors, which types without a fixed size (SVE, RVV)
// cannot be in; and they fuse multiplication and addition, rounding once, which the rest cannot: processors
// with nothing else take the one-by-one path, whose std::fma gives the same bits slowly.
#define HWY_DISABLED_TARGETS                                                                     \
  (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV | HWY_SSE4 | HWY_SSSE3 | HWY_WASM | \
   HWY_WASM_EMU256 | HWY_PPC8)

/// True in the code for processors without such vectors.
#define RINGSPLAT_ONE_BY_ONE (HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_EMU128)
