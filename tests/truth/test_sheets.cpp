// Pictures of the sheets engine against its own method's truth and against the field.
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "classify/auto_preset.hpp"
#include "frame/quality.hpp"
#include "sampled_errors.hpp"
#include "support/catch.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const Camera oblique{.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2};

FrameSpec sheets_spec(const TransferFunction& tf, Shading shading = Shading::phong, Sheets sheets = {},
                      const Camera& camera = oblique, int size = 96) {
  FrameSpec spec = plain_spec(tf, size, camera);
  spec.shown.shading = shading;
  spec.how = sheets;
  return spec;
}

/// Marschner and Lobb 1994.
Volume marschner_lobb(int n) {
  return sample_field(
      n,
      [](double x, double y, double z) {
        constexpr double pi = 3.14159265358979, f = 6, a = 0.25;
        x = 2 * x - 1, y = 2 * y - 1, z = 2 * z - 1;
        const double rho = std::cos(2 * pi * f * std::cos(pi * std::hypot(x, y) / 2));
        return 255 * ((1 - std::sin(pi * z / 2)) + a * (1 + rho)) / (2 * (1 + a));
      },
      ScalarType::uint8);
}

}  // namespace

TEST_CASE("the head's pictures are their method's, and near the field, whatever the axis") {
  const Volume volume = head();
  struct {
    const char* preset;
    Shading shading;
    double field;
  } const cases[] = {{"mr-soft", Shading::phong, 0.4},
                     {"mr-soft", Shading::none, 0.13},
                     {"mr-surface", Shading::phong, 0.7},
                     {"mr-surface", Shading::none, 0.4}};
  const Camera views[] = {
      {.azimuth = 20, .elevation = 10}, {.azimuth = 70, .elevation = 20}, {.elevation = 65}};
  for (const auto& [preset, shading, bound] : cases)
    for (const Camera& camera : views) {
      FrameSpec spec = sheets_spec(head_preset(preset), shading, {}, camera, 160);
      const Image picture = rendered(volume, spec);
      const SampledErrors errors = from_field(volume, spec, 4000);
      const double field = errors.of(picture), method = from_method(volume, spec, 4000).of(picture);
      spec.as<Sheets>().adaptive = false;
      const double fixed = errors.of(rendered(volume, spec));
      CAPTURE(preset, shading, camera.azimuth);
      CHECK(field < bound);
      CHECK(method < 0.3);
      CHECK(field < fixed + std::max(0.3 * fixed, 0.07));
    }
}

TEST_CASE("an image in the slices' plane errs by its warp, and less with more samples") {
  const Volume volume = head();
  FrameSpec spec = sheets_spec(head_preset("mr-soft"), Shading::phong, {},
                               {.azimuth = 20, .elevation = 10, .zoom = 2}, 320);
  const Image true_picture = field_image(volume, spec);
  double last = 1e300;
  for (const double samples : {1.0, 1.5, 2.0}) {
    spec.how = Sheets{ImagePlane::slices, samples};
    const double error = truth::compare(rendered(volume, spec), true_picture).total.rmse;
    CAPTURE(samples);
    CHECK(error < std::min(last, 2.8));
    last = error;
  }
}

TEST_CASE("Marschner and Lobb's signal behind a steep function") {
  const Volume volume = marschner_lobb(64);
  TransferFunction tf;
  tf.colours = {{0, {0.9, 0.5, 0.2}}, {255, {0.9, 0.8, 0.6}}};
  tf.opacities = {{120, 0.0}, {132, 0.9}, {255, 0.9}};
  // Between slices a ray runs through several cells, where the field is not linear: oblique views need more
  // slabs, as their method's truth says.
  for (const auto& [azimuth, bound] : {std::pair{0.0, 0.6}, {20.0, 0.8}, {45.0, 1.8}}) {
    CAPTURE(azimuth);
    CHECK(field_error(volume, sheets_spec(tf, Shading::phong, {}, {.azimuth = azimuth, .zoom = 2}, 160)) <
          bound);
  }
}

TEST_CASE("the lower face of a box belongs to it, the upper one does not") {
  const Volume volume = make_volume({10, 11, 12}, ScalarType::uint8, [](int, int, int) { return 1; });
  const VoxelBox parts[] = {{{0, 0, 0}, {10, 11, 12}}, {{2, 3, 4}, {7, 8, 9}}};
  for (const VoxelBox& part : parts)
    for (const bool clipped : {false, true}) {
      if (!clipped && part.first.x > 0) continue;
      // One pixel a voxel, seen along z: pixel centres lie on the voxels' faces.
      const Camera camera{.matrix = std::array<double, 12>{1, 0, 0, 2, 0, 1, 0, 2, 0, 0, 1, 0}};
      FrameSpec spec = sheets_spec(constant_opacity(0.3), Shading::none, {}, camera, 16);
      if (clipped) spec.shown.clip = part;
      for (const Image& image :
           {rendered(volume, spec), method_image(volume, spec), field_image(volume, spec)})
        for (int y = 0; y < 16; ++y)
          for (int x = 0; x < 16; ++x) {
            const bool inside =
                x - 1 >= part.first.x && x - 1 < part.end.x && y - 1 >= part.first.y && y - 1 < part.end.y;
            INFO(x << ' ' << y << (clipped ? " clipped" : ""));
            REQUIRE((image.pixel(x, y)[3] > 0.5F) == inside);
            if (!inside) REQUIRE(image.pixel(x, y)[3] == 0.0F);
          }
    }
}

TEST_CASE("a slab that adds a fiftieth or more to a pixel is lit at two points, others at one") {
  const Volume volume = make_volume({16, 16, 8}, ScalarType::float32, pattern);
  const auto drawn = [&](double opacity, bool adaptive) {
    return rendered(
        volume, sheets_spec(constant_opacity(opacity), Shading::phong,
                            {.slabs = 1, .light_points = 2, .adaptive = adaptive}, {.elevation = 90}, 48));
  };
  CHECK(largest_difference(drawn(0.1, true), drawn(0.1, false)) == 0);
  CHECK(largest_difference(drawn(0.012, true), drawn(0.012, false)) > 0);
}

TEST_CASE("4,096 faint slices") {
  for (const double opacity : {1e-4, 1e-6}) {
    const Volume volume = make_volume({6, 4096, 6}, ScalarType::uint8, [](int, int, int) { return 100; });
    const FrameSpec spec = sheets_spec(constant_opacity(opacity), Shading::none, {}, {.zoom = 300}, 16);
    const Image image = rendered(volume, spec), exact = method_image(volume, spec);
    CHECK(exact.pixel(8, 8)[3] > 0.8 * (1 - std::exp(-4096 * opacity)));
    CHECK(std::abs(image.pixel(8, 8)[3] / exact.pixel(8, 8)[3] - 1) < 0.02);
  }
}

TEST_CASE("a jump from clear to opaque, and all opaque") {
  // Of lit noise the light would be that at the slab's front, wherever the ray enters it.
  const Volume noise = make_volume({20, 21, 22}, ScalarType::float32, pattern);
  const Volume smooth =
      make_volume({20, 21, 22}, ScalarType::float32, [](int x, int y, int z) { return (x + y + z) / 60.0; });
  for (const double from : {0.5, -1.0}) {
    const FrameSpec lit = sheets_spec(constant_opacity(1.0, from)),
                    unlit = sheets_spec(constant_opacity(1.0, from), Shading::none);
    CHECK(all_finite(rendered(noise, lit)));
    CAPTURE(from);
    CHECK(method_error(noise, unlit) < 0.6);
    CHECK(method_error(smooth, lit) < 0.3);
  }
}

namespace {

/// A ball of cells about twenty points; each cell's number is one of `labels`, 0 outside.
Volume pieces(ScalarType type, const std::vector<double>& labels, int n = 40) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0, n);
  std::vector<glm::dvec3> points(20);
  for (auto& point : points) point = {place(random), place(random), place(random)};
  return make_volume(glm::ivec3(n), type, [&](int x, int y, int z) {
    const glm::dvec3 here(x, y, z);
    const auto nearest = std::min_element(points.begin(), points.end(), [&](const auto& a, const auto& b) {
      return glm::distance(a, here) < glm::distance(b, here);
    });
    const bool inside = glm::distance(here, glm::dvec3(0.5 * (n - 1))) < 0.45 * n;
    return inside ? labels[std::size_t(nearest - points.begin()) % labels.size()] : 0;
  });
}

FrameSpec label_spec(const TransferFunction& tf, Shading shading, const Sheets& sheets,
                     const Camera& camera) {
  FrameSpec spec = sheets_spec(tf, shading, sheets, camera, 128);
  spec.shown.interpolation = Interpolation::nearest;
  return spec;
}

}  // namespace

TEST_CASE("labels keep their values between voxels, whatever their numbers, and are near the field") {
  struct {
    ScalarType type;
    std::vector<double> labels;
  } const cases[] = {{ScalarType::uint8, {1, 2, 3, 7, 41}},
                     {ScalarType::int32, {1002, 17, 2035, 14175, 3}},
                     {ScalarType::float32, {-3, 1, 250, 4000, 60000}}};
  struct {
    Camera camera;
    double lit_field;
  } const views[] = {{{}, 0.15},
                     {{.azimuth = 20, .elevation = 10}, 0.4},
                     {{.azimuth = 45, .elevation = 35}, 1.0},
                     {{.azimuth = 30, .elevation = 20, .fov = 50}, 0.8}};
  for (const auto& [type, labels] : cases) {
    const Volume volume = pieces(type, labels);
    std::vector<double> ascending = labels;
    std::sort(ascending.begin(), ascending.end());
    const TransferFunction tf = label_function(ascending);
    for (const auto& [camera, bound] : views)
      for (const Shading shading : {Shading::none, Shading::phong}) {
        const FrameSpec spec = label_spec(tf, shading, {}, camera);
        CAPTURE(to_string(type), camera.azimuth, shading);
        CHECK(method_error(volume, spec) < 0.1);
        CHECK(field_error(volume, spec) < (shading == Shading::none ? 0.1 : bound));
      }
  }
}

TEST_CASE("no label that is not there is seen between others, in any quality") {
  // Of red, green and blue labels the volume has no green one.
  const Volume volume = pieces(ScalarType::uint8, {1, 3});
  TransferFunction tf = constant_opacity(0);
  tf.colours = {{1.5, {1, 0, 0}}, {1.5, {0, 1, 0}}, {2.5, {0, 1, 0}}, {2.5, {0, 0, 1}}};
  tf.opacities = {{0.5, 0.0}, {0.5, 0.9}};
  for (const Sheets& sheets :
       {sheets_of(Quality::draft), sheets_of(Quality::normal), sheets_of(Quality::best), Sheets{.slabs = 1}})
    for (const Camera& camera : {Camera{}, oblique, Camera{.azimuth = 30, .elevation = 20, .fov = 50}}) {
      FrameSpec spec = label_spec(tf, Shading::phong, sheets, camera);
      spec.shown.material.specular = 0;
      const auto green = [&] {
        const Image image = rendered(volume, spec);
        float most = 0;
        for (std::size_t k = 1; k < image.rgba.size(); k += 4) most = std::max(most, image.rgba[k]);
        return most;
      };
      CHECK(green() == 0.0F);
      spec.shown.interpolation = Interpolation::linear;
      CHECK(green() > 0.1F);
    }
}

TEST_CASE("values that are not a number, infinite, tiny and huge") {
  for (const double scale : {1.0, 1e30, 1e-30}) {
    for (const auto type : {ScalarType::float32, ScalarType::float64}) {
      const Volume volume = make_volume({20, 21, 22}, type, [&](int x, int y, int z) {
        if (x + y + z == 31) return std::numeric_limits<double>::quiet_NaN();
        if (scale == 1 && x == 3 && y == 4) return std::numeric_limits<double>::infinity();
        return scale * double(x + y + z) / 63;
      });
      FrameSpec spec = sheets_spec(ramp(0.2 * scale, scale, 0.5), Shading::none);
      const Image picture = rendered(volume, spec);
      CHECK(all_finite(picture));
      CHECK(brightest(picture) > 0.1F);
      CAPTURE(to_string(type), scale);
      CHECK(truth::compare(picture, method_image(volume, spec)).total.rmse < 1.0);
    }
  }
}

TEST_CASE("a narrow function of wide integers, and one outlier") {
  // Three units of sixteen bits: an even table would have one entry for eighty such functions.
  const Volume narrow = make_volume({24, 25, 26}, ScalarType::uint16,
                                    [](int x, int y, int z) { return 30000 + 0.5 * (x + y + z); });
  Volume outlier = narrow;
  const std::uint16_t far = 65535;
  std::memcpy(outlier.bytes.data(), &far, sizeof far);
  TransferFunction tf;
  tf.colours = {{30010, {1, 0.5, 0.2}}, {30020, {0.2, 0.5, 1}}};
  tf.opacities = {{30010, 0.0}, {30011, 0.6}, {30012, 0.6}, {30013, 0.0}};
  for (const Volume* volume : {&narrow, static_cast<const Volume*>(&outlier)}) {
    const FrameSpec spec = sheets_spec(tf, Shading::none, {.adaptive = false});
    CHECK(brightest(rendered(*volume, spec)) > 0.2F);
    CHECK(method_error(*volume, spec) < 1.5);
  }
}

TEST_CASE("flat and long voxels err no more than cubes, from any side") {
  const auto waves = [](glm::dvec3 p) {
    return 120 + 60 * std::sin(0.35 * p.x) * std::cos(0.3 * p.y + 0.1 * p.z) +
           60 * std::sin(0.25 * p.z + 0.2 * p.x);
  };
  for (const glm::dvec3 spacing : {glm::dvec3(1, 1, 4), {1, 1, 10}, {10, 1, 1}}) {
    const glm::ivec3 dims(50.0 / spacing);
    const Volume volume = make_volume(
        dims, ScalarType::uint8, [&](int x, int y, int z) { return waves(glm::dvec3(x, y, z) * spacing); },
        spacing);
    for (const Shading shading : {Shading::none, Shading::phong})
      for (int degrees = 0; degrees <= 90; degrees += 6) {
        // From the flat side to the narrow one, whichever axis is long.
        const Camera camera = spacing.z > 1 ? Camera{.azimuth = 25, .elevation = double(degrees)}
                                            : Camera{.azimuth = double(degrees), .elevation = 15};
        const FrameSpec spec = sheets_spec(head_preset("mr-soft"), shading, {}, camera, 128);
        CAPTURE(spacing.x, spacing.z, shading, degrees);
        CHECK(from_field(volume, spec, 500).of(rendered(volume, spec)) < 0.5);
      }
  }
}

TEST_CASE("layers far thinner than the table's entries") {
  const auto wave = [](int x, int y, int z) {
    return 127 + 120 * std::sin(0.045 * x + 0.3) * std::cos(0.04 * y) * std::sin(0.05 * z + 0.5);
  };
  for (const auto& [type, scale, first] : {std::tuple{ScalarType::uint8, 1.0, 0.0},
                                           {ScalarType::float32, 1.0, 0.0},
                                           // A hundredth of the range.
                                           {ScalarType::uint16, 2.0, 30000.0}}) {
    const double by = scale, from = first;
    Volume volume =
        make_volume({38, 34, 30}, type, [&](int x, int y, int z) { return from + by * wave(x, y, z); });
    const std::uint16_t far = 60000;
    if (type == ScalarType::uint16) std::memcpy(volume.bytes.data(), &far, sizeof far);
    TransferFunction tf;
    tf.colours = {{from, {0.9, 0.5, 0.2}}, {from + 255 * by, {0.3, 0.6, 1}}};
    tf.opacities = {{from, 0.0}};
    for (int k = 0; k < 14; ++k)
      for (const auto& [beside, opacity] : {std::pair{-1.0, 0.0}, {0.0, 0.7}, {1.0, 0.0}})
        tf.opacities.push_back({from + by * (9 + 17 * k + beside), opacity});
    tf.opacities.push_back({from + 255 * by, 0.0});
    for (int slabs = 1; slabs <= 4; ++slabs) {
      const FrameSpec spec = sheets_spec(tf, Shading::none, {.slabs = slabs});
      CAPTURE(to_string(type), slabs);
      CHECK(method_error(volume, spec) < 0.2);
      if (slabs >= 3) CHECK(from_field(volume, spec, 2000).of(rendered(volume, spec)) < 1.0);
    }
  }
}

TEST_CASE("in a small picture an image in the slices' plane errs as in a large one") {
  const Volume volume = head();
  double large = 0;
  for (const int size : {512, 128, 64}) {
    const FrameSpec spec =
        sheets_spec(head_preset("mr-soft"), Shading::phong,
                    {.image_plane = ImagePlane::slices, .plane_samples = 1.5, .slabs = 2}, {20, 10}, size);
    const double error = from_field(volume, spec, 1500).of(rendered(volume, spec));
    CAPTURE(size);
    if (size == 512) large = error;
    CHECK(error < 1.5 * large);
  }
}

TEST_CASE("thin sheets of voxels, flat and single-slice volumes, and tilted lattices of 1 : 1 : 10") {
  const auto sheet = [](int, int, int z) { return z == 11 ? 200.0 : 0.0; };
  struct {
    Volume volume;
    Camera camera;
  } const cases[] = {
      {make_volume({24, 24, 24}, ScalarType::uint8, sheet), oblique},
      {make_volume({30, 30, 1}, ScalarType::uint8, [](int x, int y, int) { return x * y % 200; }),
       {.elevation = 60}},
      {make_volume({1, 1, 1}, ScalarType::uint8, [](int, int, int) { return 200; }), oblique},
      {make_volume({1, 30, 2}, ScalarType::uint8, [](int, int y, int z) { return 50 + 3 * y + z; }), oblique},
      {make_volume({40, 40, 6}, ScalarType::uint8,
                   [](int x, int y, int z) { return 100 + 50 * std::sin(x + y * z); }, {1, 1, 10}),
       oblique}};
  for (const auto& [volume, camera] : cases)
    for (const Shading shading : {Shading::none, Shading::phong}) {
      const FrameSpec spec = sheets_spec(ramp(20, 255, 0.6), shading, {.adaptive = false}, camera);
      CAPTURE(volume.grid.dims.x, volume.grid.dims.z, shading);
      CHECK(brightest(rendered(volume, spec)) > 0.05F);
      CHECK(method_error(volume, spec) < 0.6);
    }
}

TEST_CASE("values exactly at a jump have the opacity behind it") {
  for (const auto type : {ScalarType::uint8, ScalarType::uint16, ScalarType::float32}) {
    const Volume volume =
        make_volume({20, 21, 22}, type, [](int x, int y, int) { return x > 9 && y > 9 ? 100.0 : 3.0; });
    const FrameSpec spec = sheets_spec(constant_opacity(0.5, 100), Shading::none, {.adaptive = false});
    CHECK(brightest(rendered(volume, spec)) > 0.9F);
    CHECK(method_error(volume, spec) < 0.6);
  }
}

TEST_CASE("a jump between two whole numbers is not moved to one of them") {
  const auto ball = [](ScalarType type) {
    return make_volume(glm::ivec3(32), type, [](int x, int y, int z) {
      return std::round(std::max(0.0, 127 - 8 * glm::distance({x, y, z}, glm::dvec3(15.5))));
    });
  };
  for (const double from : {63.3, 63.6}) {
    const FrameSpec spec = sheets_spec(constant_opacity(0.5, from), Shading::none);
    const double of_floats = field_error(ball(ScalarType::float32), spec);
    for (const auto type : {ScalarType::int8, ScalarType::uint16}) {
      CAPTURE(to_string(type), from);
      CHECK(field_error(ball(type), spec) < 1.2 * of_floats);
    }
  }
}

TEST_CASE("far and near, a voxel may be a tenth of a pixel or a hundred") {
  const Volume volume = make_volume({40, 41, 42}, ScalarType::uint8, [](int x, int y, int z) {
    return 120 + 100 * std::sin(0.3 * x) * std::cos(0.25 * y) * std::sin(0.2 * z);
  });
  for (const double zoom : {0.05, 0.3, 1.0, 8.0, 60.0}) {
    Camera camera = oblique;
    camera.zoom = zoom;
    CAPTURE(zoom);
    CHECK(method_error(volume, sheets_spec(ramp(100, 255, 0.4), Shading::phong, {}, camera)) < 0.6);
  }
}
