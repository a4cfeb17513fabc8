#pragma once
#include <cstddef>

namespace ringsplat {

/// Composites `floats` floats of a slice's row behind the image's, and clears them in the slice. Pixels are
/// premultiplied RGBA; C = fma(1 − A, c, C) and A = fma(1 − A, a, A) in float32, with a and c clamped to [0,
/// 1] and [0, a]. Summing the opacity keeps the digits of slices as faint as 1e-7, which a product of
/// transmittances loses. Pixels whose transmittance 1 − A is below `opaque` stay as they are.
///
/// Both pointers are 64-byte aligned and `floats` is a multiple of 16.
void composite_row(float* slice, float* image, std::size_t floats, float opaque);

}  // namespace ringsplat
