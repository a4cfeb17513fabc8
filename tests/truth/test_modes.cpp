// Pictures that show something else than composited light: extrema, means, integrals, surfaces.
#include <fmt/format.h>

#include <limits>
#include <numeric>

#include "frame/slices.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr Mode all_modes[] = {Mode::mip, Mode::minip, Mode::mean, Mode::sum, Mode::surface, Mode::attenuated};

const Camera cameras[] = {{.azimuth = 31, .elevation = 17, .roll = 9, .zoom = 1.1},
                          {.azimuth = 90, .zoom = 0.8},
                          {.azimuth = 200, .elevation = -68},
                          {.azimuth = 45, .elevation = 35, .fov = 60}};

/// Red is a value's place in [low, high]; blue falls.
TransferFunction window(double low, double high) {
  TransferFunction tf;
  tf.colours = {{low, {0, 0.2, 1}}, {high, {1, 0.2, 0}}};
  tf.opacities = {{low, 1.0}, {high, 1.0}};
  return tf;
}

FrameSpec mode_spec(Mode mode, const Camera& camera, double low, double high) {
  FrameSpec spec = plain_spec(window(low, high), 41, camera);
  spec.how = Sheets{};
  spec.shown.mode = mode;
  spec.shown.isovalue = 0.5 * (low + high);
  if (mode == Mode::attenuated) spec.shown.transfer_function.opacities = {{low, 0.0}, {high, 0.1}};
  return spec;
}

double trilinear_at(const truth::Scene& scene, const glm::dvec3& place) {
  const glm::ivec3 last = scene.grid.dims - 1;
  const glm::dvec3 inside = glm::clamp(place, glm::dvec3(0), glm::dvec3(last));
  const glm::ivec3 low = glm::min(glm::ivec3(glm::floor(inside)), glm::max(last - 1, 0));
  const glm::dvec3 part = inside - glm::dvec3(low);
  double value = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 step(corner & 1, corner >> 1 & 1, corner >> 2);
    const glm::dvec3 weights = glm::mix(1.0 - part, part, glm::dvec3(step));
    value += weights.x * weights.y * weights.z * scene.values[scene.index(glm::min(low + step, last))];
  }
  return value;
}

/// By many small steps. A surface that is only touched between two of them is missed.
truth::Rgba marched(const truth::Scene& scene, truth::Pixel pixel) {
  const truth::LatticeRay ray = truth::Rays(scene).through(pixel);
  if (!(ray.enter < ray.leave)) return truth::Rgba(0.0);
  constexpr int steps = 20'000;
  const double length = ray.leave - ray.enter,
               unit = std::min({scene.grid.spacing.x, scene.grid.spacing.y, scene.grid.spacing.z});
  const TransferFunction& tf = scene.frame.shown.transfer_function;
  const double low = tf.colours.front().value, high = tf.colours.back().value,
               let_through = 1 - tf.opacities.back().opacity;
  double most = -INFINITY, least = INFINITY, sum = 0, before = NAN, depth = 0, left = 0;
  bool crossed = false;
  for (int k = 0; k < steps; ++k) {
    const double value = trilinear_at(scene, ray.at(ray.enter + (k + 0.5) / steps * length));
    most = std::max(most, value);
    least = std::min(least, value);
    sum += value;
    const double share = std::clamp((value - low) / (high - low), 0.0, 1.0);
    left = std::max(left, share * std::pow(let_through, depth + 0.5 * share * length / steps));
    depth += share * length / steps;
    crossed =
        crossed || (k > 0 && (value >= scene.frame.shown.isovalue) != (before >= scene.frame.shown.isovalue));
    before = value;
  }
  const double mean = sum / steps;
  if (scene.frame.shown.mode == Mode::surface)
    return crossed ? truth::Rgba(
                         scene.frame.shown.transfer_function.evaluate(scene.frame.shown.isovalue).colour, 1)
                   : truth::Rgba(0);
  const double value = scene.frame.shown.mode == Mode::mip          ? most
                       : scene.frame.shown.mode == Mode::minip      ? least
                       : scene.frame.shown.mode == Mode::mean       ? mean
                       : scene.frame.shown.mode == Mode::attenuated ? std::lerp(low, high, left)
                                                                    : mean * length * unit;
  return truth::Rgba(scene.frame.shown.transfer_function.evaluate(value).colour, 1);
}

double difference(const truth::Rgba& a, const truth::Rgba& b) {
  double largest = 0;
  for (int c = 0; c < 4; ++c) largest = std::max(largest, std::abs(a[c] - b[c]));
  return largest;
}

Volume noise(ScalarType type, double scale, glm::ivec3 dims = {9, 7, 8}) {
  std::mt19937 random(7);
  return make_volume(dims, type, [&](int, int, int) { return scale * double(random() % 256) / 255; },
                     {1, 0.6, 2});
}

FrameSpec depth_spec(const TransferFunction& tf, const Camera& camera, double opacity) {
  FrameSpec spec = mode_spec(Mode::composite, camera, 0, 1);
  spec.shown.transfer_function = tf;
  spec.shown.depth = opacity;
  return spec;
}

Image true_depths(const Volume& volume, const FrameSpec& spec) {
  Image image;
  take_depths(image, field_image(volume, depth_frame_of(spec)));
  return image;
}

std::size_t depths_of(const Image& image) {
  return std::size_t(std::ranges::count_if(image.depth, [](float z) { return std::isfinite(z); }));
}

/// How many differ by `within` world lengths or more, or are in one picture only.
std::size_t depths_apart(const Image& a, const Image& b, double within) {
  REQUIRE(a.depth.size() == b.depth.size());
  return std::inner_product(a.depth.begin(), a.depth.end(), b.depth.begin(), std::size_t{0}, std::plus(),
                            [=](float x, float y) { return x == y || std::abs(x - y) < within ? 0 : 1; });
}

}  // namespace

TEST_CASE("the field's truth of all modes is that of an independent marcher") {
  const Volume volume = noise(ScalarType::float64, 1);
  for (const Mode mode : all_modes)
    for (const Camera& camera : cameras) {
      const truth::Scene scene = scene_of(volume, mode_spec(mode, camera, 0, mode == Mode::sum ? 15 : 1));
      const auto pixels = random_pixels(41, 41, 40, 3);
      const auto colours = truth::field_truth(scene, pixels);
      int wrong = 0;
      for (std::size_t k = 0; k < pixels.size(); ++k)
        wrong += difference(colours[k], marched(scene, pixels[k])) > (mode == Mode::attenuated ? 5e-4 : 1e-4);
      INFO(name(mode) << ", azimuth " << camera.azimuth);
      CHECK(wrong == 0);
    }
}

TEST_CASE("sheets draw all modes as the field's truth has them") {
  const struct {
    ScalarType type;
    double scale;
  } types[] = {{ScalarType::uint8, 255}, {ScalarType::uint16, 65535}, {ScalarType::float32, 1e-3}};
  for (const auto& [type, scale] : types)
    for (const Mode mode : all_modes)
      for (const Camera& camera : cameras) {
        const Volume volume = noise(type, scale, {14, 19, 17});
        FrameSpec spec = mode_spec(mode, camera, 0, scale * (mode == Mode::sum ? 20 : 1));
        INFO(name(mode) << ", " << to_string(type) << ", azimuth " << camera.azimuth);
        const Image image = rendered(volume, spec);
        CHECK(brightest(image) > 0.2F);
        CHECK(largest_difference(image, field_image(volume, spec)) < 0.5 / 255);
        spec.shown.clip = VoxelBox{{2, 3, 1}, {11, 16, 13}};
        CHECK(largest_difference(rendered(volume, spec), field_image(volume, spec)) < 0.5 / 255);
      }
}

TEST_CASE("values that others dim leave what a marcher finds, also in narrow windows and in thick haze") {
  const Volume volume = noise(ScalarType::uint8, 255);
  for (const auto& [opacity, levels] : {std::pair{0.05, 1.0}, {0.5, 4.0}, {0.9, 12.0}})
    for (const auto& [low, high] : {std::pair{0.0, 255.0}, {40.0, 120.0}, {180.0, 600.0}})
      for (const Camera& camera : cameras) {
        FrameSpec spec = mode_spec(Mode::attenuated, camera, low, high);
        spec.shown.transfer_function.opacities.back().opacity = opacity;
        const Image image = rendered(volume, spec), truth = field_image(volume, spec);
        INFO("opacity " << opacity << ", " << low << " to " << high << ", azimuth " << camera.azimuth
                        << ", off by " << 255 * largest_difference(image, truth));
        CHECK(largest_difference(image, truth) < levels / 255);
        const truth::Scene scene = scene_of(volume, spec);
        const auto pixels = random_pixels(41, 41, 20, 9);
        const auto colours = truth::field_truth(scene, pixels);
        double most = 0;
        for (std::size_t k = 0; k < pixels.size(); ++k)
          most = std::max(most, difference(colours[k], marched(scene, pixels[k])));
        CHECK(most < 5e-3);
      }
}

TEST_CASE("values that dim nothing leave the largest") {
  const Volume volume = noise(ScalarType::uint8, 255, {14, 19, 17});
  FrameSpec dim = mode_spec(Mode::attenuated, cameras[0], 0, 255);
  dim.shown.transfer_function.opacities.back().opacity = 0;
  CHECK(largest_difference(rendered(volume, dim),
                           rendered(volume, mode_spec(Mode::mip, cameras[0], 0, 255))) < 0.4 / 255);
}

TEST_CASE("a single bright voxel shows its own value, wherever rays pass") {
  const Volume volume = make_volume({21, 21, 21}, ScalarType::uint8, [](int x, int y, int z) {
    return x == 10 && y == 10 && z == 10 ? 200 : 3;
  });
  // The middle pixel's ray goes through the voxel.
  for (const double azimuth : {0.0, 17.0, 45.0, 77.0}) {
    const FrameSpec spec =
        mode_spec(Mode::mip, {.azimuth = azimuth, .elevation = azimuth / 2, .zoom = 1}, 0, 255);
    const Image image = rendered(volume, spec);
    CHECK(image.rgba[4 * (20 * 41 + 20)] == Approx(window(0, 255).evaluate(200).colour.x).margin(0.002));
  }
}

TEST_CASE("an integral is in world lengths, and a mean is the same however long the ray") {
  const Volume volume =
      make_volume({12, 10, 8}, ScalarType::float32, [](int, int, int) { return 3; }, {0.5, 0.5, 2});
  for (const Camera& camera : cameras) {
    const FrameSpec sums = mode_spec(Mode::sum, camera, 0, 60), means = mode_spec(Mode::mean, camera, 0, 6);
    const Image sum = rendered(volume, sums), mean = rendered(volume, means);
    const truth::Scene scene = scene_of(volume, sums);
    for (const truth::Pixel& pixel : random_pixels(41, 41, 200, 5)) {
      const double length =
          0.5 * truth::length_in_box(truth::cube_ray(scene, pixel), glm::dvec3(0.0), glm::dvec3(1.0));
      const std::size_t at = 4 * std::size_t(pixel.y * 41 + pixel.x);
      if (length < 0.01) continue;
      CHECK(sum.rgba[at] == Approx(sums.shown.transfer_function.evaluate(3 * length).colour.x).margin(1e-3));
      CHECK(mean.rgba[at] == Approx(means.shown.transfer_function.evaluate(3).colour.x).margin(1e-3));
    }
  }
}

TEST_CASE("with --values pixels hold a ray's numbers in all modes") {
  const Volume volume = noise(ScalarType::uint8, 255, {14, 19, 17});
  for (const Mode mode : all_modes)
    for (const Camera& camera : cameras) {
      FrameSpec spec = mode_spec(mode, camera, 0, 255);
      spec.shown.values = true;
      INFO(name(mode) << ", azimuth " << camera.azimuth);
      for (const auto& clip : {std::optional<VoxelBox>(), std::optional(VoxelBox{{2, 3, 1}, {11, 16, 13}})}) {
        spec.shown.clip = clip;
        const Image image = rendered(volume, spec), truth = field_image(volume, spec);
        // Of 255, and of some 30 lengths. Positions are rounded, so a ray that grazes a surface may meet the
        // next one, and one through the box's edge may be much longer.
        std::size_t apart = 0;
        for (std::size_t k = 0; k < image.rgba.size(); ++k)
          apart +=
              std::abs(image.rgba[k] - truth.rgba[k]) > (mode == Mode::attenuated ? 0.5F : 0.02F) ? 1 : 0;
        CHECK(brightest(image) >= 1);
        CHECK(apart < image.rgba.size() / 200);
      }
    }
}

TEST_CASE("a surface does not close holes that are not a number") {
  std::mt19937 random(3);
  const Volume volume = make_volume({17, 19, 18}, ScalarType::float32, [&](int x, int y, int z) {
    return random() % 9 == 0 ? double(NAN) : std::hypot(x - 8, y - 9, z - 8.5) + double(random() % 64) / 64;
  });
  for (const Camera& camera : cameras)
    for (const bool values : {false, true}) {
      FrameSpec spec = mode_spec(Mode::surface, camera, 0, 12);
      spec.shown.isovalue = 6;
      spec.shown.values = values;
      const Image image = rendered(volume, spec), truth = field_image(volume, spec);
      std::size_t apart = 0, there = 0;
      for (std::size_t k = 3; k < image.rgba.size(); k += 4) {
        there += truth.rgba[k] > 0;
        apart += std::abs(image.rgba[k - 3] - truth.rgba[k - 3]) > 0.02F || image.rgba[k] != truth.rgba[k];
      }
      INFO("azimuth " << camera.azimuth << ": " << apart << " of " << there << " pixels differ");
      CHECK(there > 40);
      CHECK(apart == 0);
    }
}

TEST_CASE("a surface's distance counts from the plane through the middle, in perspective, too") {
  const Volume volume =
      make_volume({21, 15, 17}, ScalarType::float32, [](int x, int, int) { return x; }, {0.5, 1, 1});
  for (const double fov : {0.0, 50.0}) {
    FrameSpec spec = mode_spec(Mode::surface, {.azimuth = 90, .fov = fov}, 0, 20);
    spec.shown.values = true;
    spec.shown.isovalue = 15.25;
    const Image image = rendered(volume, spec);
    int there = 0;
    for (std::size_t at = 0; at < image.rgba.size(); at += 4)
      if (image.rgba[at + 3] > 0) {
        ++there;
        CHECK(image.rgba[at] == Approx(-0.5 * (15.25 - 10)).margin(1e-4));
      }
    CHECK(there > 400);
  }
}

TEST_CASE("values that are not a number are no values in any mode") {
  const Volume volume = make_volume({13, 12, 11}, ScalarType::float32, [](int x, int y, int z) {
    return x == 6 && y > 3 ? std::numeric_limits<double>::quiet_NaN() : 0.1 * ((3 * x + 5 * y + 7 * z) % 10);
  });
  for (const Mode mode : {Mode::mip, Mode::minip, Mode::sum, Mode::attenuated}) {
    const FrameSpec spec = mode_spec(mode, cameras[0], 0, mode == Mode::sum ? 8 : 1);
    CHECK(largest_difference(rendered(volume, spec), field_image(volume, spec)) < 0.5 / 255);
  }
}

TEST_CASE("a ray that meets nothing but holes has no extremum, and is no ray of the least value") {
  const Volume volume = make_volume({17, 16, 15}, ScalarType::float32, [](int x, int y, int z) {
    return y > 9 || (x > 7 && y > 5) ? std::numeric_limits<double>::quiet_NaN()
           : x < 3                   ? 2.0
                                     : (3 * x + 5 * y + 7 * z) % 10;
  });
  for (const Mode mode : {Mode::mip, Mode::minip})
    for (const Camera& camera : cameras)
      for (const bool values : {false, true})
        for (const bool slice : {false, true}) {
          FrameSpec spec = mode_spec(mode, camera, 2, 9);
          spec.shown.values = values;
          if (slice) spec.shown.clip_planes = planes_of_slice({{1, 0.4, 1}, 0.3}, volume.grid);
          const Image image = rendered(volume, spec), truth = field_image(volume, spec);
          const truth::Scene scene = scene_of(volume, spec);
          int clear = 0, apart = 0, met = 0;
          for (std::size_t k = 3; k < image.rgba.size(); k += 4) {
            const truth::Pixel pixel{int(k / 4 % 41), int(k / 4 / 41)};
            const bool meets =
                truth::Rays(scene).through(pixel).enter < truth::Rays(scene).through(pixel).leave;
            clear += meets && truth.rgba[k] == 0;
            met += truth.rgba[k] == 1;
            apart +=
                std::abs(image.rgba[k - 3] - truth.rgba[k - 3]) > 0.01F || image.rgba[k] != truth.rgba[k];
          }
          CAPTURE(name(mode), camera.azimuth, values, slice, clear, met);
          CHECK(clear > (slice ? 40 : 0));
          CHECK(met > 40);
          CHECK(apart == 0);
        }
}

TEST_CASE("a lit surface is as bright as the field's truth") {
  const Volume volume = sample_field(
      24, [](double x, double y, double z) { return 1 - 2 * std::hypot(x - 0.5, y - 0.45, z - 0.55); });
  for (const Camera& camera : cameras) {
    FrameSpec spec = mode_spec(Mode::surface, camera, 0, 0.8);
    spec.shown.shading = Shading::phong;
    const Image image = rendered(volume, spec), truth = field_image(volume, spec);
    CHECK(brightest(image) > 0.3F);
    CHECK(largest_difference(image, truth) < 2.0 / 255);
  }
}

TEST_CASE("what cannot be drawn in a mode is refused") {
  FrameSpec spec = mode_spec(Mode::mip, cameras[0], 0, 1);
  spec.how = Splats{};
  CHECK_THROWS_WITH(check(spec), Catch::Contains("splats cannot be drawn by --mode mip"));
  spec.how = Sheets{};
  spec.shown.interpolation = Interpolation::nearest;
  CHECK_THROWS_WITH(check(spec), Catch::Contains("--mode mip needs values between voxels"));
  spec = mode_spec(Mode::mip, cameras[0], 0, 1);
  spec.shown.depth = 0.5;
  CHECK_THROWS_WITH(check(spec), Catch::Contains("--mode mip shows nothing that lies at one depth"));
  spec.shown.mode = Mode::composite;
  spec.how = Splats{};
  CHECK_THROWS_WITH(check(spec), Catch::Contains("splats have no depth"));
  spec.how = Sheets{.layers = 8};
  spec.shown.values = true;
  CHECK_THROWS_WITH(check(spec), Catch::Contains("no layers to composite"));
  spec.shown.depth = 1;
  CHECK_THROWS_WITH(check(spec), Catch::Contains("is no opacity that every ray could reach"));
}

TEST_CASE("in a homogenous box an opacity is reached after the length that it takes") {
  const Volume volume =
      make_volume({30, 26, 22}, ScalarType::uint8, [](int, int, int) { return 100; }, {0.5, 0.5, 1});
  for (const Camera& camera : cameras)
    for (const auto& [opacity, threshold, reached] :
         {std::tuple{0.5, 0.0, 0.5}, {0.8, 1.0 / 512, 0.8}, {0.8, 0.75, 0.8}}) {
      FrameSpec spec = depth_spec(constant_opacity(0.1), camera, opacity);
      spec.shown.opaque_threshold = threshold;
      Image expected;
      const truth::Scene scene = scene_of(volume, spec);
      const truth::Rays rays(scene);
      for (const truth::Pixel& pixel : truth::all_pixels(41, 41)) {
        const truth::LatticeRay ray = rays.through(pixel);
        const double at = ray.enter + std::log1p(-reached) / std::log1p(-0.1);
        expected.depth.push_back(at < ray.leave
                                     ? float(rays.view().project(ray.at(at)).z / rays.view().pixels_per_unit)
                                     : INFINITY);
      }
      CHECK(depths_of(expected) > 100);
      const auto source = memory_source(volume.grid, volume.bytes);
      CHECK(depths_apart(render_loopback(*source, spec, 1, 1).image, expected, 2e-3) < 3);
      if (reached == opacity) CHECK(depths_apart(true_depths(volume, spec), expected, 1e-5) == 0);
    }
}

TEST_CASE("a ball's depth is that of its surface, composited or as a surface") {
  const Volume volume = sample_field(
      40, [](double x, double y, double z) { return 200 * (0.5 - glm::length(glm::dvec3(x, y, z) - 0.5)); });
  FrameSpec spec = depth_spec(constant_opacity(1, 30), cameras[0], 0.5);
  const double pixel = 1 / truth::view_of(scene_of(volume, spec)).pixels_per_unit;
  for (const auto& [mode, within] : {std::pair{Mode::composite, 0.25}, {Mode::surface, 0.03}}) {
    spec.shown.mode = mode;
    spec.shown.isovalue = 30;
    const Image image = rendered(volume, spec);
    for (int k = 0; k < 41 * 41; ++k) {
      const double beside = pixel * glm::length(glm::dvec2(k % 41, k / 41) - 20.0);
      if (beside < 10)
        CHECK(image.depth[std::size_t(k)] ==
              Approx(-std::sqrt(14.0 * 14.0 - beside * beside)).margin(within));
    }
  }
}

TEST_CASE("sheets find the field's depths to a twentieth of a voxel, and with jumps to a fifth") {
  struct {
    ScalarType type;
    double scale, within;
    std::function<void(Shown&)> change;
  } const cases[] = {
      {ScalarType::float32, 1e-3, 0.05, [](Shown&) {}},
      {ScalarType::uint8, 1, 0.05, [](Shown& s) { s.depth = 0.9; }},
      {ScalarType::uint8, 1, 0.005, [](Shown& s) { s.interpolation = Interpolation::nearest; }},
      {ScalarType::uint8, 1, 0.05,
       [](Shown& s) {
         s.edges = EdgeOpacity{10, 60};
       }},
      {ScalarType::uint8, 1, 0.05,
       [](Shown& s) {
         s.clip_planes = {{{1, -0.5, 0.3}, -1}};
       }},
      {ScalarType::uint8, 1, 0.05,
       [](Shown& s) {
         s.clip = VoxelBox{{2, 3, 1}, {11, 14, 16}};
       }},
      {ScalarType::uint8, 1, 0.2, [](Shown& s) { s.transfer_function = constant_opacity(0.9, 90); }}};
  for (const auto& [type, scale, within, change] : cases)
    for (const Camera& camera : cameras) {
      const auto value = [&, times = scale](int x, int y, int z) { return times * noisy_lump(x, y, z); };
      const Volume volume = make_volume(lump_dims, type, value, lump_spacing);
      FrameSpec spec = depth_spec(ramp(20 * scale, 250 * scale, 0.5), camera, 0.5);
      change(spec.shown);
      const Image truth = true_depths(volume, spec);
      CHECK(depths_of(truth) > 60);
      CHECK(depths_apart(rendered(volume, spec), truth, within) <= depths_of(truth) / 30);
    }
}
