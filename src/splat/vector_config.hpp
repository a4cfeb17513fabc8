#pragma once
// Included before Highway. The kernels keep arrays of vectors, which types without a fixed size (SVE, RVV)
// cannot be in.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
