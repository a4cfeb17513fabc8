#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/vector_targets.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// Bright from 60 to 110 and, faintly, from 170 on; nothing between.
TransferFunction two_bands(double scale = 1) {
  TransferFunction tf;
  tf.colours = {{0.0, {0.9, 0.4, 0.2}}, {255 * scale, {0.3, 0.6, 1.0}}};
  tf.opacities = {{60 * scale, 0.0},  {70 * scale, 0.8},  {100 * scale, 0.8},
                  {110 * scale, 0.0}, {170 * scale, 0.0}, {255 * scale, 0.3}};
  return tf;
}

/// More layers than the table has entries for.
TransferFunction thin_layers(double scale) {
  TransferFunction tf = two_bands(scale);
  tf.opacities.clear();
  for (int k = 0; k < 12; ++k)
    for (const auto& [beside, opacity] : {std::pair{-1.0, 0.0}, {0.0, 0.7}, {1.0, 0.0}})
      tf.opacities.push_back({(15 + 20 * k + beside) * scale, opacity});
  return tf;
}

FrameSpec sheets_view(const Camera& camera, const Sheets& sheets = {}) {
  FrameSpec spec = oblique_view(90, 74, 0);
  spec.shown.camera = camera;
  spec.shown.transfer_function = two_bands();
  spec.how = sheets;
  return spec;
}

const Camera views[] = {{.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2},
                        {.azimuth = 10, .elevation = 75, .zoom = 3},
                        {.azimuth = 210, .elevation = 33, .roll = 8, .zoom = 1.2, .fov = 50},
                        {.azimuth = 123, .elevation = -30, .zoom = 0.4},
                        {.azimuth = 50, .elevation = -60, .zoom = 0.7, .fov = 90, .distance = 1.1},
                        {.azimuth = 0, .elevation = 0, .zoom = 1},
                        {.azimuth = 33, .elevation = 21, .zoom = 0.6, .fov = 10},
                        {.azimuth = 45, .elevation = 35, .zoom = 2, .fov = 150, .distance = 1.3}};
const auto some_views = std::span(views).first(4);  ///< along each axis, and one from an eye

bool shows_something(const Image& image) {
  return *std::max_element(image.rgba.begin(), image.rgba.end()) > 0.1F;
}

/// Values of a test volume, scaled into another type; some are not a number.
std::unique_ptr<VolumeSource> retyped(const std::string& name, glm::ivec3 dims, ScalarType type, double scale,
                                      std::vector<std::byte>& storage) {
  const auto source = synth_source(name, make_grid(dims));
  std::vector<std::byte> voxels(source->grid().bytes());
  source->read_slices(0, dims.z, voxels);
  const Grid grid = make_grid(dims, type, {1, 1.3, 0.7});
  storage.resize(grid.bytes());
  visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    for (std::size_t k = 0; k < voxels.size(); ++k) {
      T value = static_cast<T>(double(std::to_integer<int>(voxels[k])) * scale);
      if constexpr (std::is_floating_point_v<T>)
        if (k % 1009 == 0) value = std::numeric_limits<T>::quiet_NaN();
      std::memcpy(storage.data() + k * sizeof(T), &value, sizeof(T));
    }
  });
  return memory_source(grid, storage);
}

}  // namespace

TEST_CASE("sheets draw the same bits for any ranks, regions, roles and order of messages") {
  const auto source = synth_source("jack", make_grid({41, 37, 45}));
  struct {
    Sheets sheets;
    Interpolation interpolation;
  } const cases[] = {{{}, Interpolation::linear},
                     {{ImagePlane::slices, 2}, Interpolation::linear},
                     {{.layers = 9}, Interpolation::linear},
                     {{}, Interpolation::nearest}};
  for (const Camera& camera : views)
    for (const auto& [sheets, interpolation] : cases) {
      FrameSpec spec = sheets_view(camera, sheets);
      spec.shown.interpolation = interpolation;
      const Image plain = render_loopback(*source, spec, 1, 1).image;
      spec.shown.depth = 0.05;
      const Image alone = render_loopback(*source, spec, 1, 1).image;
      REQUIRE(shows_something(alone));
      REQUIRE(std::ranges::count_if(alone.depth, [](float z) { return std::isfinite(z); }) > 30);
      CHECK(alone.rgba == plain.rgba);
      CHECK(render_loopback(*source, spec, mesh_layout(2, 3, 6), {.reorder = true}).image == alone);
      for (const auto& [gps, renderers, region_size] : {std::tuple{3, 2, 0}, {1, 4, 0}, {5, 7, 20}})
        for (const auto placement : {Placement::dedicated, Placement::colocated}) {
          const LoopbackOptions shuffled{.seed = std::uint64_t(gps), .reorder = true};
          spec.division.region_size = region_size;
          CAPTURE(camera.azimuth, gps, renderers);
          CHECK(render_loopback(*source, spec, gps, renderers, shuffled, placement).image == alone);
        }
    }
}

TEST_CASE("sheets draw the same bits with every vector instruction set and any number of threads") {
  std::vector<std::byte> storage;
  struct {
    ScalarType type;
    double scale;
    Sheets sheets;
    bool layered = false, nearest = false;
  } const cases[] = {{ScalarType::uint8, 1, {}},
                     {ScalarType::uint8, 1, {.slabs = 1, .light_points = 1}},
                     {ScalarType::uint8, 1, {.slabs = 2}},
                     {ScalarType::uint16, 1, {.slabs = 4}},
                     {ScalarType::uint8, 1, {.adaptive = false}},
                     {ScalarType::uint16, 257, {}},
                     {ScalarType::int16, 3, {.slabs = 3}},
                     {ScalarType::float32, 1e-3, {}},
                     {ScalarType::float64, 1e35, {.slabs = 4}},
                     {ScalarType::uint8, 1, {}, true},
                     {ScalarType::float32, 1e-3, {}, true},
                     {ScalarType::uint8, 1, {}, false, true},
                     {ScalarType::uint16, 257, {.slabs = 1, .light_points = 1}, false, true},
                     {ScalarType::float32, 1e-3, {}, false, true}};
  for (const auto& [type, scale, sheets, layered, nearest] : cases)
    for (const Camera& camera : some_views) {
      const auto source = retyped("jack", {30, 34, 27}, type, scale, storage);
      FrameSpec spec = sheets_view(camera, sheets);
      spec.shown.interpolation = nearest ? Interpolation::nearest : Interpolation::linear;
      spec.shown.transfer_function = layered ? thin_layers(scale) : two_bands(scale);
      spec.shown.depth = 0.05;
      const Image best = render_loopback(*source, spec, 1, 1).image;
      INFO(fmt::format("{} values, azimuth {}, {} slabs", to_string(type), camera.azimuth, sheets.slabs));
      REQUIRE(shows_something(best));
      for (const std::string& target : vector_targets()) {
        INFO(target);
        use_vector_target(target);
        CHECK(render_loopback(*source, spec, 1, 2).image == best);
      }
      use_vector_target("");
      EngineOptions three;
      three.threads_per_rank = 3;
      CHECK(render_loopback(*source, spec, 2, 2, {}, Placement::dedicated, {}, three).image == best);
    }
}

TEST_CASE("all modes draw the same bits for any ranks, threads and vector instruction sets") {
  std::vector<std::byte> storage;
  for (const Mode mode : {Mode::mip, Mode::minip, Mode::mean, Mode::sum, Mode::surface, Mode::attenuated})
    for (const auto& [type, scale] : {std::pair{ScalarType::uint8, 1.0}, {ScalarType::float32, 1e-3}})
      for (const Camera& camera : some_views) {
        const auto source = retyped("jack", {30, 34, 27}, type, scale, storage);
        FrameSpec spec = sheets_view(camera);
        spec.shown.mode = mode;
        spec.shown.isovalue = 90 * scale;
        spec.shown.transfer_function = two_bands(scale * (mode == Mode::sum ? 20 : 1));
        for (auto& point : spec.shown.transfer_function.opacities)
          point.opacity = mode == Mode::attenuated ? 0.1 : 1;
        const Image alone = render_loopback(*source, spec, 1, 1).image;
        INFO(fmt::format("{}, {}, azimuth {}", name(mode), to_string(type), camera.azimuth));
        REQUIRE(shows_something(alone));
        for (const std::string& target : vector_targets()) {
          INFO(target);
          use_vector_target(target);
          CHECK(render_loopback(*source, spec, 1, 2).image == alone);
        }
        use_vector_target("");
        LoopbackOptions shuffled;
        shuffled.reorder = true;
        EngineOptions three;
        three.threads_per_rank = 3;
        spec.division.region_size = 20;
        CHECK(render_loopback(*source, spec, 5, 7, shuffled).image == alone);
        CHECK(render_loopback(*source, spec, 3, 2, {}, Placement::colocated, {}, three).image == alone);
      }
}

TEST_CASE("what hides pixels changes no bit of those that it does not hide") {
  // With the threshold at its least, nothing is hidden: pixels that stay clear must not change.
  const auto source = synth_source("jack", make_grid({41, 37, 45}));
  for (const Camera& camera : views) {
    FrameSpec spec = sheets_view(camera);
    spec.shown.transfer_function.opacities[1].opacity = spec.shown.transfer_function.opacities[2].opacity =
        0.999;
    spec.shown.opaque_threshold = 0;
    const Image all = render_loopback(*source, spec, 1, 1).image;
    spec.shown.opaque_threshold = 1.0 / 512;
    const Image hidden = render_loopback(*source, spec, 2, 3).image;
    std::size_t clear = 0;
    for (std::size_t k = 0; k < all.rgba.size(); k += 4) {
      if (!(all.rgba[k + 3] < 1 - 1.0F / 256)) continue;
      ++clear;
      for (std::size_t c = 0; c < 4; ++c) REQUIRE(all.rgba[k + c] == hidden.rgba[k + c]);
    }
    CHECK(clear > all.rgba.size() / 16);
    CHECK(largest_difference(all, hidden) < 1.0 / 255);
  }
}

TEST_CASE("blocks and slices that cannot be seen, or be no ray's extremum, are not sent") {
  const auto source = synth_source("ball", make_grid({64, 64, 64}));
  for (const Mode mode : {Mode::composite, Mode::mip}) {
    FrameSpec spec = sheets_view(views[0]);
    spec.shown.mode = mode;
    const auto payload_bytes = [&](const TransferFunction& tf) {
      spec.shown.transfer_function = tf;
      return render_loopback(*source, spec, 2, 1).stats.total().payload_bytes_sent;
    };
    const double opacity = mode == Mode::mip ? 1 : 0.3;
    CHECK(payload_bytes(ramp(250, 255, opacity)) < payload_bytes(ramp(0, 255, opacity)) / 2);
    CHECK(payload_bytes(ramp(300, 400, opacity)) == 0);
  }
}
