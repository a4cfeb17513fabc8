#pragma once

namespace ringsplat {

/// A display value from 0 to 1 as linear light, and back, in single precision as OpenImageIO has them (IEC
/// 61966-2-1:1999).
float linear_of_srgb(float value);
float srgb_of_linear(float value);

}  // namespace ringsplat
