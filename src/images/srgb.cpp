#include "images/srgb.hpp"

#include <OpenImageIO/color.h>

namespace ringsplat {

float linear_of_srgb(float value) { return OIIO::sRGB_to_linear(value); }
float srgb_of_linear(float value) { return OIIO::linear_to_sRGB(value); }

}  // namespace ringsplat
