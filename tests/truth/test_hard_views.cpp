// Views and grids on which a renderer's geometry is apt to break. Bounds are on the largest difference of
// values in 0..1 from the method's own truth.
#include <fmt/format.h>

#include "frame/frame_geometry.hpp"
#include "splat/region_painter.hpp"
#include "splat/splat.hpp"
#include "support/catch.hpp"
#include "truth_support.hpp"
#include "view/slice_dda.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

double lumps(double x, double y, double z) {
  return 0.5 + 0.5 * std::sin(7 * x + 3 * y) * std::cos(5 * y - 8 * z) * std::sin(4 * z + 2 * x + 1);
}

Volume lumpy(glm::ivec3 dims, glm::dvec3 spacing = glm::dvec3(1.0)) {
  return make_volume(
      dims, ScalarType::float32,
      [&](int x, int y, int z) { return lumps((x + 0.5) / dims.x, (y + 0.5) / dims.y, (z + 0.5) / dims.z); },
      spacing);
}

FrameSpec spec_of(const Camera& camera, int size = 64) {
  FrameSpec spec = plain_spec(ramp(0.2, 1.0, 0.35), size, camera);
  spec.shown.shading = Shading::phong;
  return spec;
}

const double corner_elevation = std::atan(std::sqrt(0.5)) * 180 / M_PI;  // along the cube's diagonal

}  // namespace

TEST_CASE("views at and beside the switch of the axis") {
  // At 45 degrees two slice sets are equally parallel to the picture, along the diagonal three. The picture
  // must be the method's: renderer and truth choose by the same comparison with a margin.
  const Volume volume = lumpy(glm::ivec3(24));
  for (const double beside : {0.0, 1e-6, -1e-6, 1e-9, -1e-9, 1e-13, 1.0, -1.0})
    for (const auto& [azimuth, elevation] : {std::pair{45.0, 0.0},
                                             {0.0, 45.0},
                                             {135.0, 0.0},
                                             {45.0, corner_elevation},
                                             {225.0, -corner_elevation}}) {
      CAPTURE(azimuth, elevation, beside);
      const Camera camera{.azimuth = azimuth + beside, .elevation = elevation + beside};
      CHECK(numerical_error(volume, spec_of(camera)) < 1e-5);
    }
}

TEST_CASE("rolls, and views that mirror") {
  const Volume volume = lumpy({24, 20, 22});
  for (const double roll : {-180.0, -90.0, -45.0, 1e-7, 45.0, 90.0, 179.999})
    CHECK(numerical_error(volume, spec_of({.azimuth = 20, .elevation = 10, .roll = roll, .zoom = 1})) < 1e-5);
  for (const double sign_x : {1.0, -1.0})
    for (const double sign_z : {1.0, -1.0}) {
      Camera camera;  // depth towards +y or −y, the picture mirrored or not
      camera.matrix = {sign_x * 2.0, 0.3, 0.1,           sign_x > 0 ? 8.0 : 54.0,
                       0.1,          0.2, -2.0 * sign_z, sign_z > 0 ? 52.0 : 8.0,
                       0.2 * sign_x, 2.0, 0.3,           0.0};
      INFO(sign_x << " " << sign_z);
      const FrameSpec spec = spec_of(camera);
      REQUIRE(brightest(rendered(volume, spec)) > 0.1F);
      CHECK(numerical_error(volume, spec) < 1e-5);
    }
}

TEST_CASE("voxels a hundred times longer than wide, either way") {
  // The kernel is a sliver: its coefficients are four decades apart, and Q near its edge cancels by the ratio
  // of the axes, 1e2.
  for (const glm::dvec3 spacing : {glm::dvec3(1, 1, 100), glm::dvec3(100, 1, 1), glm::dvec3(1, 100, 1)})
    for (const double azimuth : {0.0, 30.0, 60.0}) {
      const glm::ivec3 dims = glm::ivec3(glm::dvec3(48) / glm::sqrt(spacing)) + 1;
      INFO(fmt::format("{} x {} x {} at {}", spacing.x, spacing.y, spacing.z, azimuth));
      const Volume volume = lumpy(dims, spacing);
      const FrameSpec spec = spec_of({.azimuth = azimuth, .elevation = 25, .roll = 3, .zoom = 1.5});
      REQUIRE(brightest(rendered(volume, spec)) > 0.1F);
      CHECK(numerical_error(volume, spec) < 2e-5);
    }
}

TEST_CASE("spacings of 1e-12 and 1e12, an origin at 1e9: the picture of spacing 1 at 0") {
  // Opacity is per smallest spacing and the camera fits the volume, so units must cancel, but for rounding of
  // the scale itself.
  const Volume unit = lumpy({20, 21, 22});
  const FrameSpec spec = spec_of({.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2});
  const Image expected = rendered(unit, spec);
  for (const double scale : {1e-12, 1e12}) {
    const Volume scaled = lumpy({20, 21, 22}, glm::dvec3(scale));
    CHECK(largest_difference(rendered(scaled, spec), expected) < 1e-5);
    CHECK(numerical_error(scaled, spec) < 1e-5);
    CHECK(largest_difference(field_image(scaled, spec), field_image(unit, spec)) < 1e-5);
  }
  Volume moved = unit;
  moved.grid.origin = glm::dvec3(1e9, -1e9, 1e9);
  CHECK(largest_difference(rendered(moved, spec), expected) == 0.0);
}

TEST_CASE("fifty voxels a pixel, and a voxel wider than a region") {
  // Small: kernels are widened to a pixel and 2,500 of them a slice meet in it; the float sum of a slice has
  // that many roundings.
  const Volume many = lumpy({96, 96, 24});
  FrameSpec small = spec_of({.azimuth = 10, .elevation = 80, .roll = 0, .zoom = 0.02}, 128);
  REQUIRE(brightest(rendered(many, small)) > 0.1F);
  CHECK(numerical_error(many, small) < 1e-4);
  // Large: one kernel covers the picture; D, E, F are 1e-6 and x² up to 1e6 pixels from the centre.
  const Volume few = lumpy({8, 8, 8});
  for (const double azimuth : {0.0, 27.0}) {
    FrameSpec large = spec_of({.azimuth = azimuth, .elevation = 20, .roll = 3, .zoom = 500}, 96);
    large.division.region_size = 32;
    REQUIRE(brightest(rendered(few, large)) > 0.1F);
    CHECK(numerical_error(few, large) < 1e-5);
  }
}

TEST_CASE("a picture of 16,384 x 16,384 pixels, in the region farthest from its origin") {
  // Rendered whole it would take 4 GB. A camera matrix shows the same 96 pixels in a small picture, shifted
  // by 16,288 to the origin: coefficients count from each splat's own anchor, so the pixels must not know how
  // far out they are.
  const Volume volume = lumpy({20, 21, 22});
  constexpr int far = 16384 - 96;
  const auto at = [](double x, double y) {
    Camera camera;
    camera.matrix = {2.0, 0.3, 0.1, x, 0.1, 0.2, -2.0, y, 0.2, 2.0, 0.3, 0.0};
    return camera;
  };
  FrameSpec small = spec_of(at(20, 70), 96), large = small;
  large.shown.camera = at(20 + far, 70 + far);
  large.shown.width = large.shown.height = 16384;
  const auto pixels = truth::all_pixels(96, 96);
  std::vector<truth::Pixel> far_pixels;
  for (const auto& p : pixels) far_pixels.push_back({p.x + far, p.y + far});
  const auto truth_of = [&](const FrameSpec& spec, const std::vector<truth::Pixel>& shown) {
    return truth::splat_method_truth(with_quantised_normals(scene_of(volume, spec)), shown);
  };
  // The truth itself is exact enough there: a position has 53 bits.
  CHECK(largest_difference(truth_of(small, pixels), truth_of(large, far_pixels)) < 1e-9);

  // The renderer's own path there, region by region, without the 4 GB: footprint, anchors, coefficients,
  // painter.
  const auto paint = [&](const FrameGeometry& geometry, int corner) {
    RegionPainter painter(corner, corner, 96, 96);
    const Footprint footprint =
        make_footprint(geometry.view, geometry.traversal.axis, large.as<Splats>().kernel_radius);
    painter.begin_frame(footprint);
    const auto plane = in_plane(geometry.traversal.axis);
    for (int step = 0; step < geometry.slices; ++step) {
      const int slice = geometry.traversal.slice_at(step, geometry.slices);
      SliceDda dda(geometry.view, geometry.traversal.axis, volume.grid.dims[plane.u]);
      for (int v = 0; v < volume.grid.dims[plane.v]; ++v) {
        dda.begin_row(slice, v);
        for (int u = 0; u < volume.grid.dims[plane.u]; ++u) {
          const auto position = dda.position(std::uint32_t(u));
          const Splat splat =
              make_splat(footprint, anchor(position.x, position.y), {45875, 32768, 19661, 0.02F});
          painter.draw({&splat, 1});
        }
      }
      painter.composite();
    }
    std::vector<float> tile(4 * 96 * 96);
    painter.read_tile(tile);
    return tile;
  };
  const auto near_tile = paint(make_geometry(small, volume.grid), 0),
             far_tile = paint(make_geometry(large, volume.grid), far);
  double difference = 0, brightest_value = 0;
  for (std::size_t k = 0; k < near_tile.size(); ++k) {
    difference = std::max(difference, double(std::abs(near_tile[k] - far_tile[k])));
    brightest_value = std::max(brightest_value, double(near_tile[k]));
  }
  REQUIRE(brightest_value > 0.2);
  CHECK(difference < 1e-6);
}

TEST_CASE("volumes that are a point, a line or a plane") {
  // One slice along an axis: gradients have no neighbours there, and each token makes one step.
  for (const glm::ivec3 dims : {glm::ivec3(1, 1, 1), glm::ivec3(1, 20, 21), glm::ivec3(20, 1, 21),
                                glm::ivec3(20, 21, 1), glm::ivec3(30, 1, 1), glm::ivec3(1, 1, 30)})
    for (const double azimuth : {0.0, 30.0, 90.0}) {
      const Volume volume = make_volume(dims, ScalarType::float32, [](int x, int y, int z) {
        return 0.6 + 0.03 * ((x + 2 * y + 3 * z) % 10);
      });
      const FrameSpec spec = spec_of({.azimuth = azimuth, .elevation = 20, .roll = 5, .zoom = 1});
      INFO(fmt::format("{} x {} x {} at {}", dims.x, dims.y, dims.z, azimuth));
      CHECK(brightest(rendered(volume, spec)) > 0.05F);
      CHECK(numerical_error(volume, spec) < 1e-5);
      CHECK(brightest(field_image(volume, spec)) > 0.05F);
    }
}

TEST_CASE("rays in the volume's faces meet it at its low ones, in pictures and truths alike") {
  // Their pixels' centres lie at a fortieth of the picture, where a fitted box begins.
  const Volume solid = make_volume({16, 16, 16}, ScalarType::uint8,
                                   [](int x, int y, int z) { return 150 + x + 2 * y + 3 * z; });
  for (const int size : {20, 60, 100})
    for (const auto& [azimuth, elevation] : {std::pair{0, 0}, {90, 0}, {180, 0}, {270, 0}, {0, 90}, {0, -90}})
      for (const Interpolation between : {Interpolation::linear, Interpolation::nearest}) {
        FrameSpec spec =
            plain_spec(ramp(100, 250, 0.4), size,
                       {.azimuth = double(azimuth), .elevation = double(elevation), .fit = Fit::box});
        spec.how = Sheets{};
        spec.shown.interpolation = between;
        INFO(size << ' ' << azimuth << ' ' << elevation << ' ' << name(between));
        const Image picture = rendered(solid, spec);
        CHECK(truth::compare(picture, field_image(solid, spec)).total.largest < 2);
        CHECK(truth::compare(picture, method_image(solid, spec)).total.largest < 2);
      }
}
