#pragma once

namespace ringsplat {

/// Display values (0 to 1) to linear light and back (IEC 61966-2-1:1999), in single precision with
/// OpenImageIO's results.
float linear_of_srgb(float value);
float srgb_of_linear(float value);

}  // namespace ringsplat
