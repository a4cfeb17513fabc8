// Clip planes: the truths against closed forms, and sheets against the truths.
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const std::vector<std::vector<ClipPlane>> cuts{{{{0.4, 1, -0.3}, -1.3}},
                                               {{{-1, 0.2, 0.5}, -2}, {{0.3, -0.7, 0.9}, -0.5}},
                                               {{{2, 3, 1}, -1.5}, {{-2, -3, -1}, -1.5}}};
const Camera cameras[] = {{.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2},
                          {.azimuth = 100, .elevation = -20},
                          {.azimuth = 20, .elevation = 70, .zoom = 1.4},
                          {.azimuth = -60, .elevation = 10, .fov = 40}};

FrameSpec spec_of(const Camera& camera, const std::vector<ClipPlane>& planes) {
  FrameSpec spec = plain_spec(ramp(20, 240, 0.5), 64, camera);
  spec.how = Sheets{.adaptive = false};
  spec.shown.shading = Shading::phong;
  spec.shown.clip_planes = planes;
  return spec;
}

float least_opaque(const Image& image) {
  float least = 1;
  for (std::size_t at = 3; at < image.rgba.size(); at += 4)
    if (image.rgba[at] > 0) least = std::min(least, image.rgba[at]);
  return least;
}

}  // namespace

TEST_CASE("what clip planes leave of an even medium is as opaque as it is long") {
  // From the front rays go along y: 12 voxels of it are 15 long.
  const Volume even =
      make_volume({10, 12, 10}, ScalarType::float32, [](int, int, int) { return 100; }, {1, 1.25, 1});
  const double through = 0.7;  // of a voxel's length, the unit
  FrameSpec spec = plain_spec(ramp(0, 100, 1 - through), 32, {});
  spec.how = Sheets{};
  const auto centre_opacity = [&](const std::vector<ClipPlane>& planes) {
    spec.shown.clip_planes = planes;
    const truth::Scene scene = scene_of(even, spec);
    const double truth = field_at(scene, {16, 16}).w;
    CHECK(method_at(scene, {16, 16}).w == Approx(truth).margin(1e-9));
    CHECK(rendered(even, spec).rgba[4 * (16 * 32 + 16) + 3] == Approx(truth).margin(2e-5));
    return truth;
  };
  const auto opacity = [&](double length) { return 1 - std::pow(through, length); };
  CHECK(centre_opacity({}) == Approx(opacity(15)));
  CHECK(centre_opacity({{{0, 1, 0}, 3.2}}) == Approx(opacity(7.5 - 3.2)));
  CHECK(centre_opacity({{{0, -5, 0}, 3.2}}) == Approx(opacity(7.5 - 3.2)));
  CHECK(centre_opacity({{{0, 1, 0}, -1}, {{0, -1, 0}, -1.5}}) == Approx(opacity(2.5)));
  CHECK(centre_opacity({{{0, 1, 0}, 1}, {{0, -1, 0}, 1}}) == 0);
  CHECK(centre_opacity({{{1, 0, 0}, 2}}) == 0);
  CHECK(centre_opacity({{{1, 0, 0}, -2}}) == Approx(opacity(15)));
}

TEST_CASE("sheets cut by planes are their method's, also reduced, boxed and of nearest values") {
  for (const auto& planes : cuts)
    for (const Camera& camera : cameras) {
      FrameSpec spec = spec_of(camera, planes);
      CAPTURE(camera.azimuth, planes[0].normal.x);
      const auto check_method = [&](const Volume& volume) {
        const Image image = rendered(volume, spec);
        REQUIRE(brightest(image) > 0.03F);
        const auto error = truth::compare(image, method_image(volume, spec)).total;
        CHECK(error.rmse < 0.3);
        CHECK(error.largest < 9);
      };
      check_method(lump_volume());
      spec.shown.clip = VoxelBox{{3, 2, 4}, {14, 13, 17}};
      check_method(lump_volume());
      spec.shown.clip.reset();
      spec.shown.interpolation = Interpolation::nearest;
      check_method(lump_volume(ScalarType::uint8));
    }
}

TEST_CASE("what planes cut off is nowhere to be seen, and the rest is near the field") {
  const Volume volume = lump_volume();
  for (const auto& planes : cuts)
    for (const Camera& camera : cameras) {
      FrameSpec spec = spec_of(camera, planes);
      spec.how = Sheets{};
      const Image cut = rendered(volume, spec), field = field_image(volume, spec);
      CHECK(truth::compare(cut, field).total.rmse < 1.2);
      spec.shown.clip_planes.clear();
      CHECK(truth::compare(cut, rendered(volume, spec)).total.rmse > 3);
    }
}

TEST_CASE("near a plane, too, an unlit picture has all that it interpolates") {
  // Light that changes nothing asks for the voxels of gradients besides.
  const Volume volume = make_volume({40, 37, 43}, ScalarType::uint8, [](int x, int y, int z) {
    return 128 + 120 * std::sin(0.5 * x) * std::cos(0.4 * y) * std::sin(0.3 * z + 1);
  });
  for (const Camera& camera :
       {Camera{.azimuth = 44}, Camera{.azimuth = 44, .elevation = 40}, Camera{.azimuth = 135, .fov = 70}})
    for (double distance = -3; distance < 3; distance += 0.15) {
      FrameSpec spec = spec_of(camera, {{{-1, 0, 0}, distance}});
      spec.shown.material = {.ambient = 1, .diffuse = 0, .specular = 0};
      const Image lit = rendered(volume, spec);
      spec.shown.shading = Shading::none;
      INFO("azimuth " << camera.azimuth << ", distance " << distance);
      CHECK((rendered(volume, spec).rgba == lit.rgba));
    }
}

TEST_CASE("cut by planes, all modes are as the field's truth has them") {
  const Volume volume = lump_volume();
  for (const Mode mode : {Mode::mip, Mode::minip, Mode::mean, Mode::sum, Mode::surface})
    for (const auto& planes : cuts)
      for (const Camera& camera : cameras) {
        FrameSpec spec = spec_of(camera, planes);
        spec.shown.mode = mode;
        spec.shown.isovalue = 90;
        spec.shown.values = true;
        const Image image = rendered(volume, spec), truth = field_image(volume, spec);
        std::size_t apart = 0;
        for (std::size_t k = 0; k < image.rgba.size(); ++k)
          apart += std::abs(image.rgba[k] - truth.rgba[k]) > 0.05F ? 1 : 0;
        INFO(name(mode) << ", azimuth " << camera.azimuth << ", " << apart << " apart");
        CHECK(least_opaque(image) == 1);
        CHECK(apart < image.rgba.size() / 100);
      }
}

TEST_CASE("an undersampled volume is cut where the whole is") {
  const Volume volume = make_volume({32, 32, 32}, ScalarType::float32, [](int, int, int) { return 100; });
  for (const bool prefilter : {false, true}) {
    FrameSpec spec = plain_spec(ramp(0, 100, 0.02), 40, {.azimuth = 25, .elevation = 15});
    spec.how = Sheets{};
    spec.shown.clip_planes = {{{0.3, 1, 0.2}, 2.5}};
    const Image whole = rendered(volume, spec);
    spec.shown.reduction = {.factor = 2, .prefilter = prefilter};
    CHECK(truth::compare(rendered(volume, spec), whole).total.rmse < 3);
  }
}

TEST_CASE("clip planes without a direction, five of them, and splats are refused") {
  FrameSpec spec = spec_of({}, {{{0, 0, 0}, 1}});
  CHECK(says(message_of([&] { check(spec); }), "a plane needs a direction"));
  spec.shown.clip_planes = {{{1, 0, 0}, INFINITY}};
  CHECK_THROWS_AS(check(spec), InputError);
  spec.shown.clip_planes.assign(5, {{1, 0, 0}, 0});
  CHECK(says(message_of([&] { check(spec); }), "5 clip planes are too many"));
  spec.shown.clip_planes.resize(1);
  CHECK_NOTHROW(check(spec));
  spec.how = Splats{};
  CHECK(says(message_of([&] { check(spec); }), "splats cannot be cut by a plane"));
}
