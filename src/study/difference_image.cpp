#include "study/difference_image.hpp"

#include <cmath>

namespace ringsplat::app {

Image difference_image(const Image& a, const Image& b, double scale, bool absolute) {
  Image out(a.width, a.height);
  for (std::size_t at = 0; at < out.rgba.size(); ++at) {
    const auto d = static_cast<float>(scale * (double(a.rgba[at]) - double(b.rgba[at])));
    out.rgba[at] = at % 4 == 3 ? 1.0F : absolute ? std::abs(d) : d;
  }
  return out;
}

}  // namespace ringsplat::app
