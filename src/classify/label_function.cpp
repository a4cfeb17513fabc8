#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "classify/auto_preset.hpp"
#include "classify/colour_maps.hpp"

namespace ringsplat {
namespace {

/// Well separated in CIE Lab, none of them dark: chosen as by Glasbey et al. 2007 ("Colour displays for
/// categorical images"), each as far as possible from all before it.
constexpr std::array<std::uint32_t, 64> palette{
    0xe13c3c, 0x00ff00, 0x780fff, 0xffd200, 0x0096ff, 0x1effd2, 0xff3cc3, 0x4b690f, 0xffc396, 0x874b78,
    0x0096a5, 0xb4f069, 0xf0d2ff, 0x965ae1, 0x965a00, 0xff7800, 0x96c396, 0xff87a5, 0x00ff87, 0x009600,
    0xf01eff, 0xff0078, 0xa5695a, 0xf096f0, 0xc3b44b, 0x96f0ff, 0xff0000, 0x7887b4, 0x00965a, 0xa5ff1e,
    0x3c694b, 0xb41e78, 0x00c3ff, 0x5a5ab4, 0x004bff, 0xf0a52d, 0xf0875a, 0xe1f000, 0xb400b4, 0x0069f0,
    0xa59669, 0xb42d4b, 0x78a52d, 0x3cd21e, 0x78e187, 0x00c3b4, 0xa596ff, 0xe1f096, 0xf069ff, 0xc387a5,
    0xa54ba5, 0xb43c00, 0x962de1, 0xb4c31e, 0xffb4b4, 0x87781e, 0x00ffff, 0x87b4ff, 0xff69b4, 0x1e6987,
    0xff5a78, 0xa54b2d, 0x785a2d, 0xd2964b};

}  // namespace

glm::dvec3 label_colour(double label) {
  const double count = double(palette.size());
  const double place = std::fmod(label - 1, count);
  return colour_of(palette[std::size_t(place < 0 ? place + count : place)]);
}

TransferFunction label_function(const std::vector<double>& labels) {
  TransferFunction tf;
  tf.name = "labels";
  double end = std::numeric_limits<double>::quiet_NaN();
  for (const double label : labels) {
    if (label == 0) continue;
    const double low = label - 0.5, high = label + 0.5;
    const glm::dvec3 colour = label_colour(label);
    tf.colours.insert(tf.colours.end(), {{low, colour}, {high, colour}});
    if (low == end)
      tf.opacities.back() = {high, label_opacity};
    else {
      if (!tf.opacities.empty()) tf.opacities.push_back({end, 0.0});
      tf.opacities.insert(tf.opacities.end(), {{low, 0.0}, {low, label_opacity}, {high, label_opacity}});
    }
    end = high;
  }
  if (tf.opacities.empty()) {
    tf.colours = {{0, glm::dvec3(1.0)}, {1, glm::dvec3(1.0)}};
    tf.opacities = {{0, 0.0}, {1, 0.0}};
    return tf;
  }
  tf.opacities.push_back({end, 0.0});
  return tf;
}

}  // namespace ringsplat
