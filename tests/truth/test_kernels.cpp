// Errors of each kernel option: bounds on the largest difference of values in 0..1 from the method's truth,
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

FrameSpec spec_of(const KernelOptions& kernel,
                  const Camera& camera = {.azimuth = 33, .elevation = 21, .roll = 8}, int size = 64) {
  FrameSpec spec = plain_spec(ramp(0.2, 1.0, 0.35), size, camera);
  spec.as<Splats>().kernel = kernel;
  return spec;
}

constexpr KernelOptions exact{.normalisation = Normalisation::exact};

struct Ripple {
  double rms, least, most;  ///< of the opacity, relative to the opacity it should have
};

/// The ripple in the middle of one even slice of opacity 0.01, rolled and tilted, at 1.3 pixels a voxel.
Ripple ripple_of(double radius, const KernelOptions& kernel, double tilt) {
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
  spec.as<Splats>().kernel = kernel;
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
        FrameSpec spec = spec_of({.normalisation = normalisation}, camera, 72);
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

TEST_CASE("textures and fixed point: errors as the step predicts") {
  const Volume volume = lumpy({40, 37, 43});
  const auto error_of = [&](const KernelOptions& kernel) {
    const FrameSpec spec = spec_of(kernel, {.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2}, 96);
    return truth::compare(rendered(volume, spec), method_image(volume, spec)).total;
  };
  // More phases do not always help: where a voxel's step is nearly a whole number of phases, neighbours are
  // displaced alike, and a moiré appears instead of averaging out.
  std::vector<double> by_phases;
  for (const int phases : {1, 2, 4, 8, 16}) {
    const auto error = error_of({.method = KernelMethod::texture, .phases = phases});
    UNSCOPED_INFO(fmt::format("{} phases: {:.3g} rms, {:.3g} largest", phases, error.rmse, error.largest));
    by_phases.push_back(error.rmse);
    CHECK(error.rmse <= by_phases.front());
  }
  CHECK(by_phases.back() < by_phases.front() / 8);
  CHECK(by_phases.back() > 1e-3);  // the table is in use
  double before = 1e9;
  for (const int bits : {4, 7, 10, 13, 16}) {
    const auto error = error_of({.qee_bits = bits});
    UNSCOPED_INFO(fmt::format("{} bits: {:.3g} rms, {:.3g} largest, mean {:.3g}", bits, error.rmse,
                              error.largest, error.mean));
    // Cutting loses half a last place of Q on average, and that times 2Q of its square: at seven bits weights
    // are about 1 % smaller, and pictures darker by less.
    CHECK(error.rmse < 255 * std::ldexp(2.0, -bits));
    CHECK(error.rmse < before / 4);
    CHECK(error.mean < 0);
    before = error.rmse;
  }
}

TEST_CASE("even matter: the ripple of each kernel") {
  struct Case {
    const char* name;
    KernelOptions kernel;
    double least_rms, most_rms;
  };
  constexpr KernelMethod texture = KernelMethod::texture;
  const Case cases[] = {
      {"computed", {}, 0.007, 0.013},
      {"computed, ten bits", {.qee_bits = 10}, 0.007, 0.013},
      {"computed, exact", exact, 0, 1e-5},
      {"texture, 1 phase", {.method = texture, .phases = 1}, 0.1, 0.4},
      {"texture, 4 phases", {.method = texture, .phases = 4}, 0.02, 0.1},
      {"texture, 16 phases", {.method = texture, .phases = 16}, 0.007, 0.03},
  };
  for (const double tilt : {0.0, 0.6})
    for (const auto& c : cases) {
      const Ripple ripple = ripple_of(1.6, c.kernel, tilt);
      UNSCOPED_INFO(fmt::format("{}, tilt {}: {:.3g} % rms, {:.3g} to {:.3g}", c.name, tilt, 100 * ripple.rms,
                                100 * ripple.least, 100 * ripple.most));
      CHECK(ripple.rms >= c.least_rms);
      CHECK(ripple.rms <= c.most_rms);
    }
  // Ten bits with the division show the evaluator's own error.
  const Ripple machine = ripple_of(1.6, {.qee_bits = 10, .normalisation = Normalisation::exact}, 0);
  UNSCOPED_INFO(fmt::format("ten bits, exact: {:.3g} % rms, {:.3g} to {:.3g}", 100 * machine.rms,
                            100 * machine.least, 100 * machine.most));
  CHECK(machine.rms > 1e-4);
  CHECK(machine.most < 0);
  CHECK(machine.least > -5e-3);
}
