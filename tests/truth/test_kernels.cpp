// Errors of each normalisation: bounds on the largest difference of values in 0..1 from the method's truth,
// and the ripple of even matter.
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

Volume lumpy(glm::ivec3 dims, glm::dvec3 spacing = glm::dvec3(1.0)) {
  return make_volume(dims, ScalarType::float32, lumps, spacing);
}

FrameSpec spec_of(Normalisation normalisation,
                  const Camera& camera = {.azimuth = 33, .elevation = 21, .roll = 8}, int size = 64) {
  FrameSpec spec = plain_spec(ramp(0.2, 1.0, 0.35), size, camera);
  spec.as<Splats>().normalisation = normalisation;
  return spec;
}

constexpr Normalisation exact = Normalisation::exact;

struct Ripple {
  double rms, least, most;  ///< of the opacity, relative to the opacity it should have
};

/// The ripple in the middle of one even slice of opacity 0.01, rolled and tilted, at 1.3 pixels a voxel.
Ripple ripple_of(double radius, Normalisation normalisation, double tilt) {
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
  spec.as<Splats>().kernel_radius = radius;
  spec.as<Splats>().normalisation = normalisation;
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

TEST_CASE("raw, averaged and exactly normalised kernels agree with the method's truth") {
  const Volume volume = lumpy({40, 37, 43});
  const Camera cameras[] = {{},
                            {.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2},
                            {.azimuth = 45, .elevation = 0, .roll = 0, .zoom = 1},
                            {.azimuth = 200, .elevation = -60, .roll = 100, .zoom = 0.3},
                            {.azimuth = 90, .elevation = 44, .roll = 0, .zoom = 12}};
  for (const auto& camera : cameras)
    for (const double radius : {1.0, 1.6, 2.5})
      for (const Normalisation normalisation :
           {Normalisation::none, Normalisation::constant, Normalisation::exact}) {
        FrameSpec spec = spec_of(normalisation, camera, 72);
        spec.as<Splats>().kernel_radius = radius;
        INFO(fmt::format("azimuth {}, radius {}, {}", camera.azimuth, radius, name(normalisation)));
        // The lattice sum's table errs by 8e-6 of the sum at most; the transmittance behind reduces that.
        CHECK(numerical_error(volume, spec) < 1e-5);
      }
}

TEST_CASE("exact normalisation on hard cases") {
  const Volume one = make_volume({1, 1, 1}, ScalarType::float32, [](int, int, int) { return 0.9; });
  CHECK(numerical_error(one, spec_of(exact)) < 1e-5);
  CHECK(brightest(rendered(one, spec_of(exact))) > 0.05F);
  // Slivers: the table's steps differ along the two axes.
  for (const glm::dvec3 spacing : {glm::dvec3(1, 1, 100), glm::dvec3(100, 1, 1), glm::dvec3(1, 100, 1)}) {
    const glm::ivec3 dims = glm::ivec3(glm::dvec3(48) / glm::sqrt(spacing)) + 1;
    CHECK(numerical_error(lumpy(dims, spacing),
                          spec_of(exact, {.azimuth = 30, .elevation = 25, .roll = 3, .zoom = 1.5})) < 2e-5);
  }
  // Fifty voxels a pixel: kernels are wider than 64 voxels' steps, and the sum is 1.
  CHECK(numerical_error(lumpy({96, 96, 24}),
                        spec_of(exact, {.azimuth = 10, .elevation = 80, .roll = 0, .zoom = 0.02}, 128)) <
        1e-4);
  // A voxel wider than a region.
  FrameSpec large = spec_of(exact, {.azimuth = 27, .elevation = 20, .roll = 3, .zoom = 500}, 96);
  large.division.region_size = 32;
  CHECK(numerical_error(lumpy({8, 8, 8}), large) < 1e-5);
  // Opaque voxels: sums above 1 must not be clamped before the division.
  FrameSpec opaque = spec_of(exact);
  opaque.shown.transfer_function = constant_opacity(1.0, 0.5);
  CHECK(numerical_error(lumpy({20, 21, 22}), opaque) < 1e-5);
}

TEST_CASE("even matter: the ripple of each normalisation") {
  struct Case {
    Normalisation normalisation;
    double least_rms, most_rms;
  };
  for (const double tilt : {0.0, 0.6})
    for (const auto& [normalisation, least_rms, most_rms] :
         {Case{Normalisation::constant, 0.007, 0.013}, {Normalisation::exact, 0, 1e-5}}) {
      const Ripple ripple = ripple_of(1.6, normalisation, tilt);
      INFO(fmt::format("{}, tilt {}: {:.3g} % rms, {:.3g} to {:.3g}", name(normalisation), tilt,
                       100 * ripple.rms, 100 * ripple.least, 100 * ripple.most));
      CHECK(ripple.rms >= least_rms);
      CHECK(ripple.rms <= most_rms);
    }
}
