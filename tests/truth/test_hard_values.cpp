// Values and opacities on which a renderer's arithmetic is apt to break. Bounds are on the largest difference
// of values in 0..1 from the method's own truth and, of half and byte payloads, from float payloads.
#include <fmt/format.h>

#include <limits>

#include "support/catch.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const Camera oblique{.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2};

FrameSpec spec_of(const TransferFunction& tf, Shading shading = Shading::phong) {
  FrameSpec spec = plain_spec(tf, 56, oblique);
  spec.shown.shading = shading;
  return spec;
}

struct HardCase {
  std::string name;
  Volume volume;
  TransferFunction transfer_function;
};

std::vector<HardCase> hard_cases() {
  constexpr glm::ivec3 dims{14, 15, 16};
  const TransferFunction soft = ramp(0.1, 1.0, 0.3);
  std::vector<HardCase> cases;
  const auto add = [&](const std::string& name, ScalarType type, const TransferFunction& tf,
                       const std::function<double(int, int, int)>& value) {
    cases.push_back({name, make_volume(dims, type, value), tf});
  };
  // Gradients beside such values are one-sided; they are classified as the last point, or as transparent.
  using Limits = std::numeric_limits<float>;
  for (const float odd : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(), Limits::denorm_min(),
                          Limits::max(), Limits::lowest()})
    add(fmt::format("some {}", odd), ScalarType::float32, soft,
        [odd](int x, int y, int z) { return (x + 2 * y + 3 * z) % 5 == 0 ? double(odd) : pattern(x, y, z); });
  // The end of each type's range: its table's first and last entry, differences wider than the type.
  const auto ends = [&](ScalarType type, const TransferFunction& tf, double one, double other) {
    add("ends of " + std::string(to_string(type)), type, tf,
        [one, other](int x, int y, int z) { return (x + y + z) % 3 == 0 ? one : other; });
  };
  ends(ScalarType::int16, ramp(-40000, 32767, 0.3), -32768.0, 32767.0);
  ends(ScalarType::uint32, ramp(4294967294.0, 4294967295.0, 0.3), 4294967295.0, 0.0);
  ends(ScalarType::int32, ramp(-3e9, 2147483647.0, 0.3), -2147483648.0, 2147483647.0);
  // The logarithm of 1 − 1 never enters: such a voxel stays opaque at any slice distance. Sums above 1 are
  // clamped the same way.
  add("opacity 1", ScalarType::float32, constant_opacity(1.0, 0.5), pattern);
  add("a jump", ScalarType::float32, constant_opacity(0.4, 0.5), pattern);
  // A voxel exactly at a jump has the upper side's opacity, in the table, in the exact path and in the truth.
  TransferFunction jump = ramp(0, 100, 0.1);
  jump.opacities = {{0, 0.05}, {50, 0.05}, {50, 0.9}, {100, 0.9}};
  jump.colours = {{0, {1, 0, 0}}, {50, {1, 0, 0}}, {50, {0, 0, 1}}, {100, {0, 0, 1}}};
  for (const ScalarType type : {ScalarType::uint8, ScalarType::float32})
    add("values on a jump", type, jump, [](int x, int y, int z) { return 49 + (x + 2 * y + 3 * z) % 3; });
  // No gradient, no range. Every inner normal is zero: unlit, not black.
  for (const double value : {0.0, 1.0, 255.0})
    add("constant", ScalarType::uint8, constant_opacity(0.1), [value](int, int, int) { return value; });
  add("transparent", ScalarType::float32, constant_opacity(0.5, 3), pattern);
  return cases;
}

}  // namespace

TEST_CASE("hard values are the method's, lit or not") {
  for (const HardCase& hard : hard_cases())
    for (const Shading shading : {Shading::none, Shading::phong}) {
      CAPTURE(hard.name, shading);
      FrameSpec spec = spec_of(hard.transfer_function, shading);
      spec.shown.width = spec.shown.height = 36;
      const Image exact = rendered(hard.volume, spec), method = method_image(hard.volume, spec),
                  field = field_image(hard.volume, spec);
      CHECK(all_finite(exact));
      CHECK(all_finite(field));
      CHECK(largest_difference(exact, method) < 1e-5);
      for (const Image* image : {&exact, &method, &field})
        CHECK((brightest(*image) > 0) == (hard.name != "transparent"));
    }
}

TEST_CASE("4,096 slices of opacity 1e-4 and of 1e-7") {
  // A product of transmittances would lose what each slice takes from 1: 1e-7 is within two units of its last
  // place. The sum of opacities rounds relative to itself: at most 4,096 · 2⁻²⁴ of it, and far less on the
  // average.
  for (const double opacity : {1e-4, 1e-7}) {
    const Volume volume = make_volume({6, 4096, 6}, ScalarType::uint8, [](int, int, int) { return 100; });
    FrameSpec spec =
        plain_spec(constant_opacity(opacity), 16, {.azimuth = 0, .elevation = 0, .roll = 0, .zoom = 300});
    const Image image = rendered(volume, spec), exact = method_image(volume, spec);
    const auto error = truth::compare(image, exact);
    CAPTURE(opacity, image.pixel(8, 8)[3]);
    CHECK(exact.pixel(8, 8)[3] > 4000 * opacity * 0.8);
    CHECK(error.total.largest / 255 < 5e-5 * 4096 * opacity);
  }
}

TEST_CASE("a volume of 1e-300, and one of the largest doubles") {
  // The transfer function spans these values. Interpolation and gradients must survive products that
  // underflow or overflow.
  for (const double scale : {1e-300, 1e308}) {
    const Volume volume = make_volume({12, 13, 14}, ScalarType::float64,
                                      [&](int x, int y, int z) { return scale * pattern(x, y, z); });
    TransferFunction tf = ramp(0.1, 1.0, 0.3);
    for (auto& p : tf.colours) p.value *= scale;
    for (auto& p : tf.opacities) p.value *= scale;
    const Volume moderate = make_volume({12, 13, 14}, ScalarType::float64, pattern);
    INFO(scale);
    CHECK(largest_difference(rendered(volume, spec_of(tf, Shading::none)),
                             rendered(moderate, spec_of(ramp(0.1, 1.0, 0.3), Shading::none))) < 1e-5);
    CHECK(numerical_error(volume, spec_of(tf)) < 1e-5);
  }
}

TEST_CASE("a volume of denormals is one of zeros") {
  // Ranks flush denormals, since each costs hundreds of cycles; no sensible transfer function tells them from
  // zero.
  const Volume denormal = make_volume({12, 13, 14}, ScalarType::float64,
                                      [](int x, int y, int z) { return 1e-310 * pattern(x, y, z); });
  const Volume zero = make_volume({12, 13, 14}, ScalarType::float64, [](int, int, int) { return 0; });
  const FrameSpec spec = spec_of(ramp(-0.5, 1.0, 0.3), Shading::none);
  CHECK(brightest(rendered(zero, spec)) > 0.5F);
  CHECK(rendered(denormal, spec) == rendered(zero, spec));
  CHECK(numerical_error(denormal, spec) < 1e-5);
}
