#pragma once
// Included before Highway; it leaves out two kinds of targets. The kernels keep arrays of vectors, and types
// without a fixed size (SVE, RVV) cannot be in arrays. They also fuse multiplication and addition, rounding
// once, which some targets cannot. Processors that have only such targets take Highway's emulated vectors, to
// which std::fma gives the same bits slowly.
#define HWY_DISABLED_TARGETS                                                                     \
  (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV | HWY_SSE4 | HWY_SSSE3 | HWY_WASM | \
   HWY_WASM_EMU256 | HWY_PPC8)

// Highway leaves emulated vectors out where the compiler gets upper halves of 16-bit products wrong. No
// kernel takes any, and the tests compare all bits.
#define HWY_BROKEN_EMU128 0

// With a sanitizer's checks, painters that are inlined into one function take longer than twelve minutes to
// compile. Called, each function keeps its checks.
#include <hwy/base.h>
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#undef HWY_INLINE
#define HWY_INLINE inline
#endif
