// Kernels of several radii: bounds on the largest difference of values in 0..1 from the method's truth, and
// the ripple of even matter.
#include <fmt/format.h>

#include "support/catch.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

double lumps(int x, int y, int z) {
  return 0.5 +
         0.5 * std::sin(0.4 * x + 0.2 * y) * std::cos(0.3 * y - 0.5 * z) * std::sin(0.2 * z + 0.1 * x + 1);
}

struct Ripple {
  double rms, least, most;  ///< of the opacity, relative to the opacity it should have
};

/// The ripple in the middle of one even slice of opacity 0.01, rolled and tilted, at 1.3 pixels a voxel.
Ripple ripple_of(double tilt) {
  constexpr int n = 61, size = 128;
  constexpr double scale = 1.3, turn = 0.4, opacity = 0.01;
  const Volume volume = make_volume({n, n, 1}, ScalarType::uint8, [](int, int, int) { return 1; });
  const double c = std::cos(turn) * scale, s = std::sin(turn) * scale, flat = std::cos(tilt),
               deep = std::sin(tilt);
  FrameSpec spec = plain_spec(constant_opacity(opacity), size);
  spec.shown.camera.matrix = {c,
                              -s,
                              0,
                              size / 2 - (c - s) * n / 2,
                              s * flat,
                              c * flat,
                              -deep * scale,
                              size / 2 - (c + s) * flat * n / 2,
                              s * deep,
                              c * deep,
                              flat * scale,
                              0};
  spec.as<Splats>().kernel_radius = 1.6;
  spec.shown.opacity_correction = false;
  const Image image = rendered(volume, spec);
  Ripple ripple{0, 1e9, -1e9};
  int count = 0;
  for (int y = size / 2 - 12; y < size / 2 + 12; ++y)
    for (int x = size / 2 - 24; x < size / 2 + 24; ++x, ++count) {
      const double error = double(image.pixel(x, y)[3]) / opacity - 1;
      ripple.rms += error * error;
      ripple.least = std::min(ripple.least, error);
      ripple.most = std::max(ripple.most, error);
    }
  ripple.rms = std::sqrt(ripple.rms / count);
  return ripple;
}

}  // namespace

TEST_CASE("kernels of any radius agree with the method's truth") {
  const Volume volume = make_volume({40, 37, 43}, ScalarType::float32, lumps);
  const Camera cameras[] = {{},
                            {.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2},
                            {.azimuth = 45, .elevation = 0, .roll = 0, .zoom = 1},
                            {.azimuth = 200, .elevation = -60, .roll = 100, .zoom = 0.3},
                            {.azimuth = 90, .elevation = 44, .roll = 0, .zoom = 12}};
  for (const auto& camera : cameras)
    for (const double radius : {1.0, 1.6, 2.5}) {
      FrameSpec spec = plain_spec(ramp(0.2, 1.0, 0.35), 72, camera);
      spec.as<Splats>().kernel_radius = radius;
      INFO(fmt::format("azimuth {}, radius {}", camera.azimuth, radius));
      CHECK(numerical_error(volume, spec) < 1e-5);
    }
}

TEST_CASE("even matter: the ripple of kernels that are divided by their sum's mean") {
  for (const double tilt : {0.0, 0.6}) {
    const Ripple ripple = ripple_of(tilt);
    INFO(fmt::format("tilt {}: {:.3g} % rms, {:.3g} to {:.3g}", tilt, 100 * ripple.rms, 100 * ripple.least,
                     100 * ripple.most));
    CHECK(ripple.rms >= 0.007);
    CHECK(ripple.rms <= 0.013);
  }
}
