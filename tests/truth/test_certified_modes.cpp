// Proved bounds of pictures that show extrema, means, integrals and surfaces.
#include <random>

#include "pixel_bounds.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "truth/certified.hpp"
#include "truth/enclosed_projection.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr int size = 64;
constexpr Mode modes[] = {Mode::mip, Mode::minip, Mode::mean, Mode::sum, Mode::surface, Mode::attenuated};

struct Case {
  const char* name;
  Volume volume;
};

std::vector<Case> hard_cases() {
  const auto spike = [](int x, int y, int z) { return x == 7 && y == 8 && z == 9 ? 0.97 : 0.03; };
  const glm::ivec3 dims(16);
  const auto float32 = ScalarType::float32;
  return {{"lumps", make_volume(dims, float32, lumps)},
          {"noise", make_volume({9, 8, 7}, float32, pattern)},
          {"flat voxels", make_volume({20, 18, 6}, float32, lumps, {1, 1, 4})},
          {"holes", make_volume(dims, float32, holed)},
          {"infinities", make_volume(dims, float32, endless)},
          {"spike", make_volume(dims, ScalarType::float64, spike, {1, 0.7, 1.3})},
          {"block", make_volume(dims, float32, block)},
          {"one slice", make_volume({16, 16, 1}, float32, lumps)}};
}

FrameSpec spec_of(Mode mode, const Camera& camera, Shading shading = Shading::none) {
  const double high = mode == Mode::sum ? 6 : 1;
  TransferFunction tf;
  tf.colours = {{0, {0.9, 0.2, 0.1}}, {0.5 * high, {0.1, 0.8, 0.3}}, {high, {0.2, 0.3, 1}}};
  tf.opacities = {{0.1 * high, 0.2}, {0.41 * high, 0.3}, {0.41 * high, 0.9}, {high, 1}};
  if (mode == Mode::attenuated) tf.opacities = {{0, 0}, {high, 0.15}};
  FrameSpec spec = plain_spec(tf, size, camera);
  spec.how = Sheets{};
  spec.shown.mode = mode;
  spec.shown.isovalue = 0.37;
  spec.shown.shading = shading;
  return spec;
}

std::vector<truth::PixelBounds> bounds_of(const truth::Scene& scene, std::span<const truth::Pixel> pixels) {
  return truth::certified_bounds(scene, pixels, 0.1 / 255);
}

}  // namespace

TEST_CASE("what modes without light show lies within certified bounds") {
  const auto pixels = random_pixels(size, size, 100, 1);
  for (const Case& c : hard_cases())
    for (const Camera& camera : cameras)
      for (const Mode mode : modes)
        for (const bool clipped : {false, true}) {
          if (clipped && c.volume.grid.dims.z == 1) continue;
          FrameSpec spec = spec_of(mode, camera, clipped ? Shading::phong : Shading::none);
          if (clipped) spec.shown.clip = VoxelBox{{2, 1, 1}, {8, 7, 5}};
          if (clipped && camera.fov > 0)
            spec.shown.clip_planes = {{{-1, 0.2, 0.5}, -2}, {{0.3, -0.7, 0.9}, -2.5}};
          const truth::Scene scene = scene_of(c.volume, spec);
          const auto bounds = bounds_of(scene, pixels);
          CAPTURE(c.name, name(mode), camera.azimuth, clipped);
          CHECK(outside(bounds, truth::field_truth(scene, pixels)) == 0);
          CHECK(share_within(bounds, 1e-4) >= 0.95);
        }
}

TEST_CASE("the head's certified bounds hold what modes show, and a millionth beside it is outside") {
  const auto pixels = random_pixels(256, 256, 300, 3);
  for (const Mode mode : modes) {
    FrameSpec spec = spec_of(mode, {.azimuth = 20, .elevation = 10}, Shading::phong);
    spec.shown.width = spec.shown.height = 256;
    const double high = mode == Mode::sum ? 20'000 : 248;
    spec.shown.transfer_function.colours = {{0, {0, 0.1, 0}}, {high, {1, 0.6, 1}}};
    spec.shown.transfer_function.opacities = {{0, 0.5}, {high, mode == Mode::attenuated ? 0.6 : 1}};
    spec.shown.isovalue = 60.5;
    const truth::Scene scene = scene_of(head(), spec);
    const auto bounds = bounds_of(scene, pixels);
    auto colours = truth::field_truth(scene, pixels);
    INFO(name(mode));
    CHECK(outside(bounds, colours) == 0);
    CHECK(share_within(bounds, mode == Mode::surface ? 1e-4 : 1e-7) == 1);
    std::size_t shown = 0;
    for (truth::Rgba& colour : colours) {
      shown += colour.a > 0;
      if (colour.a > 0) colour.g += 1e-6;
    }
    CHECK(shown > 50);
    if (mode != Mode::surface) CHECK(outside(bounds, colours, 0) == shown);
  }
}

TEST_CASE("certified bounds of modes tell scenes apart that differ by a millionth") {
  constexpr double millionth = 1e-6;
  const auto pixels = random_pixels(size, size, 80, 5);
  const Volume volume = make_volume({9, 8, 7}, ScalarType::float32, pattern);
  for (const Mode mode : modes) {
    const Shading shading = mode == Mode::surface ? Shading::phong : Shading::none;
    const truth::Scene scene = scene_of(volume, spec_of(mode, cameras[0], shading));
    const auto bounds = bounds_of(scene, pixels);
    const auto changed = [&](const char* what, const std::function<void(truth::Scene&)>& change) {
      truth::Scene other = scene;
      change(other);
      INFO(name(mode) << ", " << what);
      CHECK(outside(bounds, truth::field_truth(other, pixels), 0) > 0);
    };
    changed("azimuth", [](auto& s) { s.frame.shown.camera.azimuth += 57 * millionth; });
    changed("zoom", [](auto& s) { s.frame.shown.camera.zoom *= 1 + millionth; });
    changed("spacing", [](auto& s) { s.grid.spacing.x *= 1 + millionth; });
    changed("colour", [](auto& s) { s.frame.shown.transfer_function.colours[1].srgb.g += millionth; });
    changed("voxels", [](auto& s) {
      for (double& v : s.values) v *= 1 + millionth;
    });
    if (mode == Mode::surface)
      changed("isovalue", [](auto& s) { s.frame.shown.isovalue += millionth; });
    else
      changed("opacity", [](auto& s) { s.frame.shown.transfer_function.opacities[1].opacity += millionth; });
  }
}

TEST_CASE("bounds hold what is on either side of a face that a ray runs along") {
  // Rays from straight before run along the voxels' centres; those at x = 5 have no values on one side, or
  // none in their front half.
  const auto columns = [](int last_row, double further) {
    return make_volume({8, 8, 8}, ScalarType::float64, [=](int x, int y, int) {
      if (y > last_row) return further;
      return x < 5 ? std::numeric_limits<double>::quiet_NaN() : x == 5 ? 0.9 : 0.3;
    });
  };
  const Volume all = columns(7, 0), front = columns(3, 0.95);
  const auto pixels = truth::all_pixels(8, 8);
  for (const Mode mode : {Mode::mip, Mode::mean, Mode::sum, Mode::attenuated}) {
    const Volume& volume = mode == Mode::attenuated ? front : all;
    FrameSpec spec = spec_of(mode, {.zoom = std::sqrt(3.0)});
    spec.shown.width = spec.shown.height = 8;
    const auto bounds = bounds_of(scene_of(volume, spec), pixels);
    INFO(name(mode));
    CHECK(bounds[4 * 8 + 5].width() > (mode == Mode::attenuated ? 0.02 : 0.1));
    CHECK(bounds[4 * 8 + 6].width() < 1e-6);
    for (const double voxels : {-1e-11, 0.0, 1e-11}) {
      spec.shown.camera.pan[0] = voxels / 8;
      CHECK(outside(bounds, truth::field_truth(scene_of(volume, spec), pixels)) == 0);
    }
  }
}

TEST_CASE("the greatest of a cubic lies within narrow bounds") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  using truth::Interval;
  double widest = 0;
  int wrong = 0;
  const auto look = [&](const std::array<double, 4>& p) {
    const Interval found =
        truth::greatest_of({Interval(p[0]), Interval(p[1]), Interval(p[2]), Interval(p[3])});
    long double most = -std::numeric_limits<double>::infinity();
    for (int k = 0; k <= 2000; ++k) {
      const long double s = k / 2000.0L;
      most = std::max(most, p[0] + s * (p[1] + s * (p[2] + s * p[3])));
    }
    wrong += !(found.upper() >= most && found.lower() >= most - 1e-14L && found.lower() < most + 1e-5L);
    widest = std::max(widest, width(found));
  };
  for (int k = 0; k < 500; ++k) {
    look({any(random), any(random), any(random), any(random)});
    const double a = 0.5 + 0.5 * any(random), b = 0.5 + 0.5 * any(random), sign = any(random);
    look({0, sign * a * b, -sign * (a + b) / 2, sign / 3});               // turns at a and at b
    look({1, sign * a * a, -sign * a, sign / 3});                         // is level at a
    look({0.25, sign * (a * a + 1e-9), -sign * a, sign / 3});             // nearly
    look({any(random), 1e-17 * any(random), 1e-16, any(random) * 1e-8});  // almost level
  }
  look({3, 0, 0, 0});
  CHECK(wrong == 0);
  CHECK(widest < 1e-13);
}

TEST_CASE("the most that is left of values lies within bounds, also in narrow windows and in thick haze") {
  const auto pixels = random_pixels(size, size, 60, 8);
  for (const Case& c : hard_cases())
    for (const Camera& camera : cameras)
      for (const double opacity : {0.0, 0.02, 0.5, 1.0})
        for (const auto& [low, high] : {std::pair{0.0, 1.0}, {0.2, 0.4}, {0.5, 7.0}}) {
          FrameSpec spec = spec_of(Mode::attenuated, camera);
          TransferFunction& tf = spec.shown.transfer_function;
          tf.colours = {{low, {0, 0.2, 1}}, {high, {1, 0.2, 0}}};
          tf.opacities.back().opacity = opacity;
          const truth::Scene scene = scene_of(c.volume, spec);
          const auto bounds = bounds_of(scene, pixels);
          CAPTURE(c.name, camera.azimuth, opacity, low);
          CHECK(outside(bounds, truth::field_truth(scene, pixels), 1e-9) == 0);
          CHECK(share_within(bounds, 1e-7) >= 0.95);
        }
}

TEST_CASE("what has no certified bounds is refused") {
  const Volume volume = hard_cases().front().volume;
  const auto refused = [&](const FrameSpec& spec, const char* named) {
    const std::vector<truth::Pixel> pixels{{3, 4}};
    CHECK_THROWS_WITH(bounds_of(scene_of(volume, spec), pixels), Catch::Contains(named));
  };
  FrameSpec spec = spec_of(Mode::mip, cameras[0]);
  spec.shown.values = true;
  refused(spec, "--values");
}
