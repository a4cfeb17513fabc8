// Proved bounds of what a segmentation tints, and of what gradients leave of opacity.
#include "pixel_bounds.hpp"
#include "support/catch.hpp"
#include "truth/certified.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr int size = 64;
constexpr double wanted = 0.1 / 255, wanted_lit = 0.5 / 255, millionth = 1e-6;

struct Case {
  const char* name;
  Volume volume;
  double opacity;  ///< the most
};

std::vector<Case> hard_cases() {
  const glm::ivec3 dims(16);
  const auto float32 = ScalarType::float32;
  return {{"lumps", make_volume(dims, float32, lumps), 0.6},
          {"opaque lumps", make_volume(dims, float32, lumps), 1},
          {"noise", make_volume({9, 8, 7}, float32, pattern, {1, 1.2, 0.7}), 0.6},
          {"holes", make_volume(dims, float32, holed), 0.6},
          {"infinities", make_volume(dims, float32, endless), 0.6}};
}

FrameSpec spec_of(const Case& c, const Camera& camera, Shading shading) {
  TransferFunction tf;
  tf.colours = {{0, {0.9, 0.2, 0.1}}, {0.5, {0.1, 0.8, 0.3}}, {1, {0.2, 0.3, 1}}};
  tf.opacities = {{0.1, 0}, {0.8, c.opacity}};
  FrameSpec spec = plain_spec(tf, size, camera);
  spec.how = Sheets{};
  spec.shown.shading = shading;
  return spec;
}

double width_of(Shading shading) { return shading == Shading::phong ? wanted_lit : wanted; }

truth::Scene tinted(const Volume& volume, FrameSpec spec, const std::function<int(int, int, int)>& label) {
  spec.shown.tints = {{1, {1, 0, 0}, 0.6F}, {2, {0, 0.5F, 1}, 1.0F}};
  truth::Scene scene = scene_of(volume, spec);
  const Volume labels = make_volume(volume.grid.dims, ScalarType::uint8, label);
  scene.labels = truth::read_labels(*memory_source(labels.grid, labels.bytes));
  return scene;
}
int cells(int x, int y, int z) { return (x / 3 + 2 * (y / 4) + z / 2) % 4; }

/// Whether some pixel shows that a scene was changed.
template <class Change>
bool is_told_apart(const std::vector<truth::PixelBounds>& bounds, truth::Scene scene,
                   std::span<const truth::Pixel> pixels, const Change& change) {
  change(scene);
  return outside(bounds, truth::field_truth(scene, pixels, 1e-10), 0) > 0;
}

}  // namespace

TEST_CASE("certified bounds hold what labels tint") {
  const auto pixels = random_pixels(size, size, 60, 1);
  for (const Case& c : hard_cases())
    for (const Camera& camera : cameras)
      for (const Shading shading : {Shading::none, Shading::phong})
        for (const Interpolation between : {Interpolation::linear, Interpolation::nearest}) {
          FrameSpec spec = spec_of(c, camera, shading);
          spec.shown.interpolation = between;
          if (camera.fov > 0) spec.shown.clip = VoxelBox{{1, 2, 1}, {8, 7, 6}};
          if (camera.roll > 0) spec.shown.clip_planes = {{{0.4, 1, -0.3}, -1.3}};
          const truth::Scene scene = tinted(c.volume, spec, cells);
          const auto bounds = truth::certified_bounds(scene, pixels, width_of(shading));
          CAPTURE(c.name, camera.azimuth, shading, name(between));
          CHECK(outside(bounds, truth::field_truth(scene, pixels, 1e-9), 1e-8) == 0);
          CHECK(share_within(bounds, width_of(shading)) >= 0.95);
        }
}

TEST_CASE("certified bounds tell tints apart that differ by a millionth") {
  const auto pixels = random_pixels(size, size, 80, 5);
  const Case lumps = hard_cases().front();
  const truth::Scene scene = tinted(lumps.volume, spec_of(lumps, cameras[0], Shading::phong), cells);
  const auto bounds = truth::certified_bounds(scene, pixels, 5e-9);
  CHECK(outside(bounds, truth::field_truth(scene, pixels, 1e-11), 1e-10) == 0);
  const auto differs = [&](const auto& change) { return is_told_apart(bounds, scene, pixels, change); };
  CHECK(differs([](auto& s) { s.frame.shown.tints[0].share += float(millionth); }));
  CHECK(differs([](auto& s) { s.frame.shown.tints[1].colour.g += float(millionth); }));
  CHECK(differs([](auto& s) { s.labels[s.index({7, 8, 6})] = 0; }));
  // Labels' places are the voxels', however little these are moved.
  CHECK(differs([](auto& s) { s.frame.shown.camera.pan[0] += millionth; }));
}

TEST_CASE("bounds hold the tints on either side of a face that a ray runs along") {
  // Seen from straight before, columns of pixels are columns of voxels' faces, which are rounded upwards.
  const Volume even = make_volume(glm::ivec3(8), ScalarType::float64, [](int, int, int) { return 0.7; });
  FrameSpec spec = spec_of({"even", even, 0.6}, {.zoom = std::sqrt(3.0)}, Shading::none);
  spec.shown.width = spec.shown.height = 8;
  const double face = 0.5 + 1e-9;
  spec.shown.camera.pan[0] = face / 8;
  const auto label = [](int x, int, int) { return x < 3 ? 1 : 2; };
  const auto pixels = truth::all_pixels(8, 8);
  const auto bounds = truth::certified_bounds(tinted(even, spec, label), pixels, wanted);
  CHECK(bounds[4 * 8 + 3].width() > 0.1);
  CHECK(bounds[4 * 8 + 6].width() < wanted);
  for (const double voxels : {-1e-11, 0.0, 1e-11}) {
    spec.shown.camera.pan[0] = (face + voxels) / 8;
    CHECK(outside(bounds, truth::field_truth(tinted(even, spec, label), pixels)) == 0);
  }
}

TEST_CASE("certified bounds hold a tinted slice, and a millionth beside it is outside") {
  const Case slice{"slice", make_volume({16, 16, 1}, ScalarType::float32, lumps), 1};
  const auto pixels = truth::all_pixels(size, size);
  for (const Camera& camera :
       {facing_slices(truth::lattice_of(slice.volume.grid), Axis::z, false), cameras[0]}) {
    FrameSpec spec = spec_of(slice, camera, Shading::none);
    spec.shown.mode = Mode::mip;
    spec.shown.transfer_function.opacities = {{0, 1}, {1, 1}};
    const truth::Scene scene = tinted(slice.volume, spec, cells);
    const auto bounds = truth::certified_bounds(scene, pixels, wanted);
    INFO(camera.azimuth);
    CHECK(outside(bounds, truth::field_truth(scene, pixels)) == 0);
    CHECK(share_within(bounds, 1e-7) >= 0.95);
    CHECK(is_told_apart(bounds, scene, pixels,
                        [](auto& s) { s.frame.shown.tints[0].share += float(millionth); }));
  }
}

TEST_CASE("certified bounds hold what gradients leave of opacity") {
  const auto pixels = random_pixels(size, size, 60, 2);
  for (const Case& c : hard_cases())
    for (const Camera& camera : cameras)
      for (const Shading shading : {Shading::none, Shading::phong})
        for (const EdgeOpacity& edges : {EdgeOpacity{0.03, 0.12}, {0, 0.25}, {0.07, 0.070001}}) {
          FrameSpec spec = spec_of(c, camera, shading);
          spec.shown.edges = edges;
          if (camera.fov > 0) spec.shown.clip = VoxelBox{{1, 2, 1}, {8, 7, 6}};
          if (camera.roll > 0) spec.shown.clip_planes = {{{0.4, 1, -0.3}, -1.3}};
          const truth::Scene scene = scene_of(c.volume, spec);
          const auto bounds = truth::certified_bounds(scene, pixels, width_of(shading));
          CAPTURE(c.name, camera.azimuth, shading, edges.from);
          CHECK(outside(bounds, truth::field_truth(scene, pixels, 1e-9), 1e-8) == 0);
          CHECK(share_within(bounds, width_of(shading)) >= 0.95);
        }
}

TEST_CASE("certified bounds hold the closed form of gradients' opacity, and nothing beside a millionth") {
  // 3 a voxel of half a world length: 6. Rays from the front cross 10 voxels that are 4 of the least long.
  const Volume ramped =
      make_volume({20, 10, 12}, ScalarType::float32, [](int x, int, int) { return 3 * x; }, {0.5, 2, 1});
  FrameSpec spec = plain_spec(ramp(-2000, -1000, 0.1), 32, {});
  const std::vector<truth::Pixel> pixels{{16, 16}};
  const auto check_share = [&](double from, double to, double share) {
    spec.shown.edges = EdgeOpacity{from, to};
    const auto found = truth::certified_bounds(scene_of(ramped, spec), pixels, 1e-9).front();
    const auto opacity = [&](double by) { return 1 - std::pow(0.9, 40 * by); };
    CAPTURE(from, to, found.low.a, found.high.a);
    CHECK(found.low.a <= opacity(share));
    CHECK(opacity(share) <= found.high.a);
    CHECK(found.width() < 1e-9);
    for (const double apart : {-millionth, millionth}) {
      if (!(share > 0 && share < 1)) continue;
      CHECK((found.low.a > opacity(share + apart) || opacity(share + apart) > found.high.a));
    }
  };
  check_share(5, 7, 0.5);
  check_share(0, 5.9, 1);
  check_share(6.2, 8, 0);
  check_share(3, 15, 0.25);
}

TEST_CASE("certified bounds tell gradients' opacities apart that differ by a millionth") {
  const auto pixels = random_pixels(size, size, 80, 5);
  const Case lumps = hard_cases().front();
  FrameSpec spec = spec_of(lumps, cameras[0], Shading::none);
  spec.shown.edges = EdgeOpacity{0.01, 0.3};
  const truth::Scene scene = scene_of(lumps.volume, spec);
  for (const double width : {1e-3, 1e-5, 5e-9})
    CHECK(share_within(truth::certified_bounds(scene, pixels, width), width) > 0.9);
  const auto bounds = truth::certified_bounds(scene, pixels, 5e-9);
  CHECK(outside(bounds, truth::field_truth(scene, pixels, 1e-11), 1e-10) == 0);
  const auto differs = [&](const auto& change) { return is_told_apart(bounds, scene, pixels, change); };
  CHECK(differs([](auto& s) { s.frame.shown.edges->from += millionth; }));
  CHECK(differs([](auto& s) { s.frame.shown.edges->to += millionth; }));
  CHECK(differs([](auto& s) { s.grid.spacing.x *= 1 + millionth; }));
}
