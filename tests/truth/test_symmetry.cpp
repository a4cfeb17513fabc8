#include <fmt/format.h>

#include "support/catch.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// A field without symmetry that has every direction of gradient.
double lopsided(int x, int y, int z) {
  return 120 + 60 * std::sin(0.9 * x + 0.3 * y * y) + 40 * std::cos(1.1 * z - 0.7 * x) * std::sin(0.8 * y);
}

FrameSpec spec_of(const Camera& camera) {
  FrameSpec spec = plain_spec(ramp(20, 255, 0.25), 64, camera);
  spec.shown.shading = Shading::phong;
  return spec;
}

/// The picture from left to right.
Image mirrored(const Image& image) {
  Image out(image.width, image.height);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      std::copy_n(image.pixel(image.width - 1 - x, y), 4, out.pixel(x, y));
  return out;
}

using Render = Image (*)(const Volume&, const FrameSpec&);
Image by_method(const Volume& v, const FrameSpec& s) { return method_image(v, s, Normals::exact); }
struct Renderer {
  const char* name;
  Render render;
  double bound;
};
constexpr Renderer renderers[] = {
    // Quantised normals turn with the volume, because their lattice has the cube's symmetries.
    {"the renderer", rendered, 1e-5},
    {"the method's truth", by_method, 1e-6},
    {"the field's truth", field_image, 3e-6},
};

}  // namespace

TEST_CASE("a turned volume gives the same picture, and a mirrored one its mirror image") {
  constexpr int n = 11;
  // Gradients of integers often lie half-way between two normals.
  const auto whole_numbers = [](int x, int y, int z) {
    return 20.0 + (x * 37 + y * 71 + z * 113 + x * y * 5 + y * z * 3) % 200;
  };
  const auto check = [](const Renderer& r, ScalarType type,
                        const std::function<double(int, int, int)>& value) {
    const Volume volume = make_volume(glm::ivec3(n), type, value);
    // Turned about z by 90 degrees: what was at (x, y) is at (n − 1 − y, x).
    const Volume turned =
        make_volume(glm::ivec3(n), type, [&](int x, int y, int z) { return value(y, n - 1 - x, z); });
    const Volume mirror =
        make_volume(glm::ivec3(n), type, [&](int x, int y, int z) { return value(n - 1 - x, y, z); });
    for (const double azimuth : {0.0, 20.0, 43.0, 110.0}) {
      INFO(r.name << " of " << to_string(type) << ", azimuth " << azimuth);
      FrameSpec spec = spec_of({.azimuth = azimuth, .elevation = 25, .roll = 6, .zoom = 1});
      const Image before = r.render(volume, spec);
      REQUIRE(brightest(before) > 0.2F);
      spec.shown.camera.azimuth += 90;
      CHECK(largest_difference(before, r.render(turned, spec)) < r.bound);
      spec.shown.camera.azimuth = -azimuth;
      spec.shown.camera.roll = -spec.shown.camera.roll;
      spec.shown.light.x = -spec.shown.light.x;
      CHECK(largest_difference(mirrored(before), r.render(mirror, spec)) < r.bound);
    }
  };
  for (const Renderer& r : renderers) check(r, ScalarType::float32, lopsided);
  check(renderers[0], ScalarType::uint8, whole_numbers);
}

TEST_CASE("a turned head is the same picture but at 45 degrees and in the slices' plane") {
  // Ties between slice sets and the origin of the slices' plane depend on the order and direction of the
  // axes, which do not turn with the volume.
  constexpr int n = 96;
  const Volume whole = head();
  const glm::ivec3 dims = whole.grid.dims;
  const auto value = [&](int x, int y, int z) {
    return std::to_integer<int>(
        whole.bytes[std::size_t(x * dims.x / n) +
                    std::size_t(dims.x) *
                        (std::size_t(y * dims.y / n) + std::size_t(dims.y) * std::size_t(z * dims.z / n))]);
  };
  const Volume volume = make_volume(glm::ivec3(n), ScalarType::uint8, value);
  const Volume turned = make_volume(glm::ivec3(n), ScalarType::uint8,
                                    [&](int x, int y, int z) { return value(y, n - 1 - x, z); });
  const auto apart = [&](const char* name, ImagePlane plane, double azimuth) {
    FrameSpec spec = plain_spec(head_preset(name), 256, {.azimuth = azimuth, .elevation = 25});
    spec.as<Splats>().image_plane = plane;
    const Image before = rendered(volume, spec);
    spec.shown.camera.azimuth += 90;
    return truth::compare(rendered(turned, spec), before).total;
  };
  for (const auto& [name, least, most] : {std::tuple{"mr-soft", 0.4, 2.0}, {"mr-surface", 1.2, 7.0}}) {
    INFO(name);
    for (const double azimuth : {20.0, 44.9999, 45.0001, 110.0})
      CHECK(apart(name, ImagePlane::screen, azimuth).largest < 5e-7 * 255);
    const truth::ErrorFigures tied = apart(name, ImagePlane::screen, 45);
    const truth::ErrorFigures in_plane = apart(name, ImagePlane::slices, 20);
    INFO("45 degrees: RMSE " << tied.rmse << ", largest " << tied.largest
                             << "; slices' plane: " << in_plane.rmse << ", " << in_plane.largest);
    for (const double rmse : {tied.rmse, in_plane.rmse}) {
      CHECK(rmse > least);
      CHECK(rmse < most);
    }
  }
}

TEST_CASE("turns about x and y, by a camera matrix") {
  constexpr int n = 9;
  const Volume volume = make_volume(glm::ivec3(n), ScalarType::float32, lopsided);
  // World to screen of the volume as it is: rows right, down, depth. Turning the volume permutes the columns,
  // up to signs.
  const double rows[3][3] = {{3.1, 1.2, -0.7}, {0.4, 1.5, 3.0}, {-1.0, 3.1, -1.3}};
  const auto spec_with = [&](const std::array<int, 3>& from, const std::array<double, 3>& sign) {
    std::array<double, 12> m{};
    glm::dvec3 centre(0.5 * (n - 1));
    for (int r = 0; r < 3; ++r) {
      double shift = r < 2 ? 32 : 0;
      for (int c = 0; c < 3; ++c) {
        m[std::size_t(4 * r + c)] = sign[std::size_t(c)] * rows[r][from[std::size_t(c)]];
        shift -= m[std::size_t(4 * r + c)] * centre[c];
      }
      m[std::size_t(4 * r + 3)] = shift;
    }
    Camera camera;
    camera.matrix = m;
    return spec_of(camera);
  };
  const Volume about_x = make_volume(glm::ivec3(n), ScalarType::float32,
                                     [](int x, int y, int z) { return lopsided(x, z, n - 1 - y); });
  const Volume about_y = make_volume(glm::ivec3(n), ScalarType::float32,
                                     [](int x, int y, int z) { return lopsided(n - 1 - z, y, x); });
  for (const auto& r : renderers) {
    INFO(r.name);
    const Image before = r.render(volume, spec_with({0, 1, 2}, {1, 1, 1}));
    REQUIRE(brightest(before) > 0.2F);
    CHECK(largest_difference(before, r.render(about_x, spec_with({0, 2, 1}, {1, -1, 1}))) < r.bound);
    CHECK(largest_difference(before, r.render(about_y, spec_with({2, 1, 0}, {1, 1, -1}))) < r.bound);
  }
}

TEST_CASE("a volume split in two by slices gives the picture of the whole") {
  // Unlit, because a gradient at the cut would need the other half. Seen along z from above: the upper half
  // is in front.
  constexpr int n = 12, cut = 5, size = 48;
  std::array<double, 12> m{2.5, 0.3, 0.2, 8, 0.2, -2.4, 0.3, 38, 0.1, 0.2, -2.5, 0};
  Camera camera;
  camera.matrix = m;
  FrameSpec spec = plain_spec(ramp(20, 255, 0.25), size, camera);
  const auto part = [&](int first, int count) {
    Volume volume = make_volume({n, n, count}, ScalarType::float32,
                                [=](int x, int y, int z) { return lopsided(x, y, z + first); });
    volume.grid.origin = {0, 0, double(first)};
    return volume;
  };
  for (const Render render : {Render(rendered), Render(by_method)}) {
    const Image whole = render(part(0, n), spec), behind = render(part(0, cut), spec),
                front = render(part(cut, n - cut), spec);
    REQUIRE(brightest(whole) > 0.5F);
    Image together(size, size);
    for (std::size_t p = 0; p < together.rgba.size(); p += 4)
      for (std::size_t c = 0; c < 4; ++c)
        together.rgba[p + c] = front.rgba[p + c] + (1 - front.rgba[p + 3]) * behind.rgba[p + c];
    CHECK(largest_difference(whole, together) < 1e-6);
  }
}
