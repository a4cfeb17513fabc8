// What a segmentation tints: the truths against closed forms, sheets against the truths, and the same bits
// for any ranks.
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "truth/ray.hpp"
#include "truth_support.hpp"
#include "volume/forwarding_source.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// A volume and its labels.
struct Tinted {
  Volume volume, labels;

  Tinted(Volume made, const std::function<int(int, int, int)>& label)
      : volume(std::move(made)), labels(make_volume(volume.grid.dims, ScalarType::uint8, label)) {}

  FrameResult rendered(const FrameSpec& spec, const Layout& layout = {},
                       const EngineOptions& engine = {}) const {
    struct Source final : ForwardingSource {
      Source(const Tinted& t)
          : ForwardingSource(memory_source(t.volume.grid, t.volume.bytes)),
            of_voxels(memory_source(t.labels.grid, t.labels.bytes)) {}
      VolumeSource* labels() override { return of_voxels.get(); }
      std::unique_ptr<VolumeSource> of_voxels;
    } source(*this);
    return render_loopback(source, spec, layout, {}, {}, engine);
  }
  truth::Scene scene(const FrameSpec& spec) const {
    truth::Scene scene = scene_of(volume, spec);
    scene.labels = truth::read_labels(*memory_source(labels.grid, labels.bytes));
    return scene;
  }
  Image method(const FrameSpec& spec) const {
    return truth::to_image(64, 64, truth::method_truth(scene(spec), truth::all_pixels(64, 64)));
  }
  Image field(const FrameSpec& spec) const {
    return truth::to_image(64, 64, truth::field_truth(scene(spec), truth::all_pixels(64, 64)));
  }
};

const std::vector<Tint> tints{{1, {1, 0, 0}, 0.6F}, {2, {0, 0.5F, 1}, 1.0F}, {3, {0, 1, 0}, 0.0F}};

FrameSpec sheets(const Camera& camera, Shading shading = Shading::none) {
  FrameSpec spec = plain_spec(ramp(20, 240, 0.5), 64, camera);
  spec.how = Sheets{.adaptive = false};
  spec.shown.shading = shading;
  spec.shown.opaque_threshold = 0;
  spec.shown.tints = tints;
  return spec;
}

double lump(int x, int y, int z) {
  return 240 * std::max(0.0, 1 - glm::length((glm::dvec3(x, y, z) - glm::dvec3(16, 13, 18)) / 16.0));
}
int cells(int x, int y, int z) { return (x / 5 + 2 * (y / 6) + z / 4) % 4; }
Tinted lumps(ScalarType type) { return {make_volume({33, 27, 37}, type, lump), cells}; }

}  // namespace

TEST_CASE("labels tint what the voxels nearest to a ray show, by their share") {
  // Seen along y, rays cross one label each, and all the same opacity.
  const Tinted halves(make_volume({16, 12, 16}, ScalarType::uint8, [](int, int, int) { return 100; }),
                      [](int x, int, int) { return x < 8 ? 1 : 3; });
  FrameSpec spec = sheets({});
  TransferFunction& tf = spec.shown.transfer_function;
  tf.colours = {{0, {1, 1, 1}}, {255, {1, 1, 1}}};
  tf.opacities = {{0, 0.2}, {255, 0.2}};
  const std::vector<truth::Pixel> beside{{29, 32}, {34, 32}};
  const auto method = truth::method_truth(halves.scene(spec), beside),
             field = truth::field_truth(halves.scene(spec), beside);
  const Image picture = halves.rendered(spec).image;
  const double opacity = 1 - std::pow(0.8, 12);
  for (std::size_t k = 0; k < beside.size(); ++k)
    for (int c = 0; c < 4; ++c) {
      const double wanted = opacity * (k == 0 && (c == 1 || c == 2) ? 0.4 : 1);
      CHECK(method[k][c] == Approx(wanted).margin(1e-7));
      CHECK(field[k][c] == Approx(wanted).margin(1e-5));
      CHECK(picture.pixel(beside[k].x, beside[k].y)[c] == Approx(wanted).margin(2e-3));
    }
}

TEST_CASE("tinted sheets are their method's, and near the field") {
  for (const ScalarType type : {ScalarType::uint8, ScalarType::float32})
    for (const Interpolation between : {Interpolation::linear, Interpolation::nearest})
      for (const Camera& camera : {Camera{.azimuth = 33, .elevation = 21, .zoom = 1.2},
                                   Camera{.azimuth = 100, .elevation = -20, .fov = 40}}) {
        const Tinted volume = lumps(type);
        FrameSpec spec = sheets(camera, Shading::phong);
        spec.shown.interpolation = between;
        const Image picture = volume.rendered(spec).image;
        INFO(to_string(type) << ' ' << name(between) << ' ' << camera.azimuth);
        CHECK(truth::compare(picture, volume.method(spec)).total.rmse < 0.3);
        CHECK(truth::compare(picture, volume.field(spec)).total.rmse < 3);
        spec.shown.clip = VoxelBox{{3, 5, 6}, {30, 20, 33}};
        CHECK(truth::compare(volume.rendered(spec).image, volume.method(spec)).total.rmse < 0.3);
        spec.shown.clip.reset();
        spec.how = Sheets{};
        CHECK(truth::compare(volume.rendered(spec).image, picture).total.rmse < 1);
        spec.shown.tints.clear();
        CHECK(truth::compare(volume.rendered(spec).image, picture).total.rmse > 5);
      }
}

TEST_CASE("tints have the same bits for any ranks, and where Renderers keep blocks") {
  const Tinted volume = lumps(ScalarType::uint16);
  for (const int factor : {1, 2}) {
    FrameSpec spec = sheets({.azimuth = 33, .elevation = 21}, Shading::phong);
    spec.how = Sheets{};
    spec.shown.reduction.factor = factor;
    const Image alone = volume.rendered(spec).image;
    for (const Layout& layout : {Layout{3, 2}, Layout{2, 5}, Layout{4, 4, Placement::colocated}})
      for (const int keep : {0, 64}) {
        EngineOptions engine;
        engine.keep = keep;
        CHECK(largest_difference(volume.rendered(spec, layout, engine).image, alone) == 0);
      }
  }
}

TEST_CASE("a slice is tinted where its voxels are") {
  const Tinted volume(make_volume({70, 61, 37}, ScalarType::uint8, lump), cells);
  FrameSpec spec = sheets(facing_slices(truth::lattice_of(volume.volume.grid), Axis::z, false));
  spec.shown.mode = Mode::mip;
  spec.shown.clip = VoxelBox{{0, 0, 18}, {70, 61, 19}};
  spec.shown.transfer_function.opacities = {{20, 1.0}, {240, 1.0}};
  const Image picture = volume.rendered(spec).image;
  CHECK(truth::compare(picture, volume.field(spec)).total.largest < 1);
  CHECK(largest_difference(volume.rendered(spec, {3, 2}).image, picture) == 0);
  // Where values are those of the window's low end labels are seen, too.
  spec.shown.transfer_function.opacities = {{150, 1.0}, {240, 1.0}};
  spec.shown.transfer_function.colours = {{150, {0, 0, 0}}, {240, {1, 1, 1}}};
  CHECK(truth::compare(volume.rendered(spec, {2, 3}).image, volume.field(spec)).total.largest < 1);
  spec.shown.tints.clear();
  CHECK(truth::compare(volume.rendered(spec).image, picture).total.rmse > 5);
}

TEST_CASE("splats are not tinted, nor are there other labels and colours") {
  FrameSpec spec = sheets({});
  CHECK_NOTHROW(check(spec));
  spec.shown.tints = {{0, {1, 0, 0}, 0.5F}};
  CHECK(says(message_of([&] { check(spec); }), "label 0 cannot have that colour"));
  spec.shown.tints = {{4, {1, 0, 2}, 0.5F}};
  CHECK(says(message_of([&] { check(spec); }), "label 4 cannot have that colour"));
  spec.shown.tints = tints;
  spec.how = Splats{};
  CHECK(says(message_of([&] { check(spec); }), "splats cannot be tinted by a segmentation"));
}
