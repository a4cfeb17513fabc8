#include <limits>

#include "support/catch.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr int size = 33;
const Camera oblique{.azimuth = 31, .elevation = 17, .roll = 9, .zoom = 1.1};

/// For a medium of one colour: the largest difference of opacity, and of red, from 1 − exp(−depth(ray)).
double largest_error(const Volume& volume, const FrameSpec& spec,
                     const std::function<double(const truth::CubeRay&)>& depth, double tolerance = 1e-6) {
  const auto scene = scene_of(volume, spec);
  const auto pixels = truth::all_pixels(spec.shown.width, spec.shown.height);
  const auto colours = truth::field_truth(scene, pixels, tolerance);
  double largest = 0;
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const double opacity = -std::expm1(-depth(truth::cube_ray(scene, pixels[p])));
    largest = std::max({largest, std::abs(colours[p].w - opacity), std::abs(colours[p].x - opacity)});
  }
  return largest;
}

/// Seen along y, through every voxel of one column.
truth::Rgba seen_along_y(const Volume& volume, const TransferFunction& tf) {
  return field_at(scene_of(volume, plain_spec(tf, 9, {.zoom = 2})), {4, 4});
}

Volume rising_along_y() {
  return make_volume({8, 8, 8}, ScalarType::float64, [](int, int y, int) { return y; });
}

}  // namespace

TEST_CASE("a constant volume is a box of its voxels' faces") {
  const Volume volume =
      make_volume({9, 12, 7}, ScalarType::uint8, [](int, int, int) { return 1; }, {1.0, 0.5, 2.0});
  // Along an axis the ray's direction has exact zeros, and most pixels look past the box on two sides at
  // once.
  for (const Camera& camera :
       {oblique, Camera{.zoom = 0.6}, Camera{.azimuth = 90, .zoom = 0.6},
        Camera{.elevation = 90, .zoom = 0.6}, Camera{.azimuth = 180, .elevation = -90}}) {
    INFO("azimuth " << camera.azimuth << ", elevation " << camera.elevation);
    CHECK(
        largest_error(volume, plain_spec(constant_opacity(0.2), size, camera), [](const truth::CubeRay& ray) {
          return -std::log(0.8) * truth::length_in_box(ray, glm::dvec3(0.0), glm::dvec3(1.0));
        }) < 1e-9);
  }
}

TEST_CASE("without interpolation each voxel is a box of its own value") {
  const glm::ivec3 dims(5, 4, 3);
  const auto value = [](int x, int y, int z) {
    return x == 2 && y == 1 ? std::numeric_limits<double>::quiet_NaN() : double((x + 2 * y + 3 * z) % 4);
  };
  const Volume volume = make_volume(dims, ScalarType::float32, value, {1.0, 1.5, 2.0});
  TransferFunction tf = constant_opacity(0);
  tf.opacities = {{0.0, 0.0}, {1.0, 0.1}, {2.0, 0.7}, {3.0, 0.3}};
  for (const Camera& camera :
       {oblique, Camera{.azimuth = 90, .pan = {0.013, 0.007}}, Camera{.azimuth = 200, .elevation = -60}}) {
    FrameSpec spec = plain_spec(tf, size, camera);
    spec.shown.interpolation = Interpolation::nearest;
    const auto depth = [&](const truth::CubeRay& ray) {
      double sum = 0;
      for (int z = 0; z < dims.z; ++z)
        for (int y = 0; y < dims.y; ++y)
          for (int x = 0; x < dims.x; ++x) {
            const glm::dvec3 corner(x, y, z), all(dims);
            const double opacity = tf.evaluate(value(x, y, z)).opacity;
            if (opacity > 0)
              sum -= std::log1p(-opacity) * truth::length_in_box(ray, corner / all, (corner + 1.0) / all);
          }
      return sum;
    };
    CHECK(largest_error(volume, spec, depth) < 1e-9);
  }
}

TEST_CASE("a transfer function with a jump cuts a slab out of a ramp, exactly") {
  // Values 0 … 15 along z; opaque matter where they lie in [5.25, 9.75].
  const Volume volume = make_volume({16, 16, 16}, ScalarType::float64, [](int, int, int z) { return z; });
  TransferFunction tf = constant_opacity(0.3);
  tf.opacities = {{5.25, 0.0}, {5.25, 0.3}, {9.75, 0.3}, {9.75, 0.0}};
  CHECK(largest_error(volume, plain_spec(tf, size, oblique), [](const truth::CubeRay& ray) {
          return -std::log(0.7) * truth::length_in_box(ray, {0, 0, 5.75 / 16}, {1, 1, 10.25 / 16});
        }) < 1e-9);
}

TEST_CASE("a linear extinction along the ray is integrated to the tolerance") {
  const Volume volume = make_volume({16, 16, 16}, ScalarType::float64, [](int, int y, int) { return y; });
  TransferFunction tf;  // seen along y: ∫ −ln(1 − 0.06 v) dv from 0 to 15, and half voxels of 0 and 15
  tf.colours = {{0, {1, 1, 1}}, {1, {1, 1, 1}}};
  tf.opacities = {{0, 0.0}, {16, 0.96}};
  const auto antiderivative = [](double v) {
    return ((1 - 0.06 * v) * std::log(1 - 0.06 * v) - (1 - 0.06 * v)) / 0.06;
  };
  const double depth = antiderivative(15) - antiderivative(0) - 0.5 * std::log(1 - 0.06 * 15);
  CHECK(largest_error(volume, plain_spec(tf, 17, {.azimuth = 0, .elevation = 0, .roll = 0, .zoom = 2}),
                      [&](const truth::CubeRay&) { return depth; }) < 1e-9);
}

TEST_CASE("colour over colour: two layers composite as they must") {
  // Looking along y: half the depth red in front (values 0), then blue (values 1), a jump half-way between
  // the middle voxels.
  const Volume volume =
      make_volume({8, 8, 8}, ScalarType::float64, [](int, int y, int) { return y < 4 ? 0 : 1; });
  TransferFunction tf = constant_opacity(0.15);
  tf.colours = {{0.5, {1, 0, 0}}, {0.5, {0, 0, 1}}};
  const auto colour = seen_along_y(volume, tf);
  const double through = std::pow(0.85, 4);
  CHECK(colour.x == Approx(1 - through).epsilon(1e-9));
  CHECK(colour.z == Approx(through * (1 - through)).epsilon(1e-9));
  CHECK(colour.w == Approx(1 - through * through).epsilon(1e-9));
}

TEST_CASE("opacity 1 ends the ray with the colour at its front") {
  TransferFunction tf;
  tf.colours = {{0, {1, 1, 1}}, {7, {0, 0, 0}}};
  tf.opacities = {{3.5, 0.0}, {3.5, 1.0}};
  const auto colour = seen_along_y(rising_along_y(), tf);
  CHECK(colour.w == 1.0);
  CHECK(colour.x == Approx(0.5).margin(1e-6));
}

TEST_CASE("opacity that reaches 1 at one value only stays finite") {
  TransferFunction tf = constant_opacity(0);
  tf.opacities = {{2.5, 0.0}, {3.5, 1.0}, {4.5, 0.0}};  // ∫ −ln(1 − t) dt = 1 on either side
  CHECK(seen_along_y(rising_along_y(), tf).w == Approx(1 - std::exp(-2.0)).margin(1e-6));
}

TEST_CASE("values that are not numbers are transparent, infinities take the end's colour") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const FrameSpec spec = plain_spec(constant_opacity(0.5, 0.5), size, oblique);
  const Volume missing = make_volume({8, 8, 8}, ScalarType::float32, [&](int, int, int) { return nan; });
  CHECK(brightest(field_image(missing, spec)) == 0.0F);
  const Volume infinite = make_volume({8, 8, 8}, ScalarType::float32, [&](int, int, int) { return inf; });
  const Volume ones = make_volume({8, 8, 8}, ScalarType::float32, [](int, int, int) { return 1; });
  CHECK(largest_difference(field_image(infinite, spec), field_image(ones, spec)) < 1e-6);
  const Volume below = make_volume({8, 8, 8}, ScalarType::float32, [&](int, int, int) { return -inf; });
  CHECK(brightest(field_image(below, spec)) == 0.0F);
}

TEST_CASE("a spike of the transfer function inside a cell is found however narrow it is") {
  const Volume volume = make_volume({16, 16, 16}, ScalarType::float64, [](int, int, int z) { return z; });
  for (const double low : {3.3, 7.7, 11.43}) {
    const double high = low + 0.004;
    TransferFunction tf = constant_opacity(0);
    tf.opacities = {{low, 0.0}, {low, 0.999999}, {high, 0.999999}, {high, 0.0}};
    for (const Camera& camera : {oblique, Camera{.elevation = 90, .zoom = 2}}) {
      CAPTURE(low, camera.elevation);
      const FrameSpec spec = plain_spec(tf, size, camera);
      REQUIRE(brightest(field_image(volume, spec)) > 0.04F);
      CHECK(largest_error(volume, spec, [&](const truth::CubeRay& ray) {
              return -std::log(1e-6) *
                     truth::length_in_box(ray, {0, 0, (low + 0.5) / 16}, {1, 1, (high + 0.5) / 16});
            }) < 1e-8);
    }
  }
}

TEST_CASE("a narrow peak up to opacity 1 has its own depth, and is no opaque sheet") {
  // Seen along y. The mean of −ln(1 − t) over a straight side is 1, so a peak is as deep as it is wide.
  const Volume volume = make_volume({8, 16, 8}, ScalarType::float64, [](int, int y, int) { return y; });
  for (const double width : {0.4, 0.004, 0.00004})
    for (const double low : {3.3, 11.43}) {
      TransferFunction tf = constant_opacity(0);
      tf.opacities = {{low, 0.0}, {low + width / 2, 1.0}, {low + width, 0.0}};
      CAPTURE(width, low);
      CHECK(seen_along_y(volume, tf).w == Approx(-std::expm1(-width)).margin(1e-8));
    }
}

TEST_CASE("space beside a voxel that is not a number is empty, and is not read as zero") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  FrameSpec spec = plain_spec(constant_opacity(0.3), 9, {.zoom = 2});  // zero is opaque, too
  spec.as<Splats>().kernel_radius = 1.6;
  // Where a slice has a voxel: its kernel, four a voxel away and four across, over their sum's mean.
  const double t = 1.6 * 1.6, sum = 1 + 4 * std::pow(1 - 1 / t, 2) + 4 * std::pow(1 - 2 / t, 2),
               seven_slices = 1 - std::pow(1 - 0.3 * sum * 3 / (M_PI * t), 7);
  // Seen along y. A missing slice costs the field the cells on both sides, or at the face one cell and half a
  // voxel.
  for (const auto& [slice, lost] : {std::pair{4, 2.0}, {0, 1.5}, {7, 1.5}}) {
    const Volume volume = make_volume({9, 8, 9}, ScalarType::float32,
                                      [&, s = slice](int, int y, int) { return y == s ? nan : 1.0; });
    INFO("slice " << slice);
    CHECK(field_at(scene_of(volume, spec), {4, 4}).w == Approx(1 - std::pow(0.7, 8 - lost)).epsilon(1e-9));
    CHECK(method_at(scene_of(volume, spec), {4, 4}).w == Approx(seven_slices).epsilon(1e-9));
    CHECK(rendered(volume, spec).pixel(4, 4)[3] == Approx(seven_slices).epsilon(2e-5));
  }
  const Volume missing = make_volume({8, 8, 8}, ScalarType::float32, [&](int, int, int) { return nan; });
  CHECK(brightest(field_image(missing, spec)) == 0.0F);
  CHECK(brightest(method_image(missing, spec)) == 0.0F);
  CHECK(brightest(rendered(missing, spec)) == 0.0F);
}

TEST_CASE("the field's truth keeps its tolerance") {
  // Compared with itself at 1e-11: a shaded, sharp, colourful scene without a closed form.
  const Volume volume = sample_field(20, synth_field("marschner-lobb"));
  TransferFunction tf;
  tf.colours = {{0.3, {1, 0.2, 0.1}}, {0.5, {0.2, 1, 0.3}}, {0.7, {0.1, 0.3, 1}}};
  tf.opacities = {{0.45, 0.0}, {0.5, 0.9}, {0.5, 0.2}, {0.65, 0.6}};
  FrameSpec spec = plain_spec(tf, 24, oblique);
  spec.shown.shading = Shading::phong;
  const auto scene = scene_of(volume, spec);
  const auto pixels = truth::all_pixels(24, 24);
  const auto fine = truth::field_truth(scene, pixels, 1e-11);
  for (const double tolerance : {1e-3, 1e-6}) {
    const auto coarse = truth::field_truth(scene, pixels, tolerance);
    INFO("tolerance " << tolerance);
    CHECK(largest_difference(coarse, fine) < tolerance);
  }
}
