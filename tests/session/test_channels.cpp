// Volumes on one grid that are drawn as one frame: projections, whose sum has the bits that it has of
// pictures that are drawn one by one, and materials.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>

#include "session/render_frames.hpp"
#include "support/catch.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const std::array<const char*, 5> names{"ball", "shell", "gaussians", "jack", "box"};

struct Case {
  ScalarType type = ScalarType::uint8;
  Mode mode = Mode::mip;
  std::size_t channels = 3;
  double fov = 0;
  bool clipped = false;
  bool mixed = false;
  int region_size = 24;
  std::optional<std::size_t> alone = std::nullopt;  ///< of all channels only this one is seen
};

TransferFunction function_of(std::size_t channel, const Case& one) {
  const double unit = one.type == ScalarType::float32 ? 1.0 / 255 : 1,
               from = one.mode == Mode::minip ? -60 : 20, step = double(channel);
  TransferFunction tf = ramp(unit * (from + 12 * step), unit * (190 + 15 * step), 0.6);
  if (one.alone && channel != *one.alone)
    for (auto& point : tf.opacities) point.opacity = 0;
  for (auto& point : tf.colours)
    for (int c = 0; c < 3; ++c) point.srgb[c] *= (int(channel) + c) % 3 == 0 ? 0.9 : 0.2;
  return tf;
}

/// A view of the channels, the last of the volumes first.
std::vector<VolumeFrame> picture_of(const Case& one, int view) {
  FrameSpec spec;
  spec.shown.mode = one.mode;
  spec.shown.mixed = one.mixed;
  spec.shown.shading = one.mixed ? Shading::phong : Shading::none;
  spec.shown.camera = {.azimuth = 17.0 * view, .elevation = 21, .fov = one.fov};
  spec.shown.width = spec.shown.height = 56;
  spec.division.region_size = one.region_size;
  if (one.clipped) {
    spec.shown.clip = VoxelBox{{2, 1, 0}, {29, 30, 21}};
    spec.shown.clip_planes = {{{1, 0.3, 0.2}, -3}};
  }
  std::vector<VolumeFrame> frames;
  for (std::size_t channel = one.channels; channel-- > 0;) {
    spec.shown.transfer_function = function_of(channel, one);
    frames.push_back({channel, spec});
  }
  return frames;
}

Scene scene_of(const Case& one, const Layout& layout, const Wiring& wiring) {
  const Grid grid = make_grid({31, 33, 29}, one.type);
  LoadOptions options = needed_along(picture_of(one, 0).front().spec, {true, true, true});
  Scene scene;
  for (std::size_t k = 0; k < names.size(); ++k) {
    OpenedVolume volume{grid, true, synth_source(names[k], grid)};
    (k == 0 ? scene : scene.others.emplace_back()) = load_scene(volume, options, layout, wiring);
  }
  return scene;
}

/// A volume of as many values in each place as there are of these, which are linear in it.
struct LinearFields {
  std::vector<glm::dvec4> rises;  ///< by x, y, z, and at the origin
  std::vector<TransferFunction> functions;
  Grid grid = make_grid({31, 33, 29}, ScalarType::float32);
};

/// What a ray shows of fields that are materials, in many small steps and double precision.
glm::dvec4 marched(const LinearFields& of, const Camera& camera, int size, int x, int y) {
  const ViewTransform view = make_view(camera, lattice_frame(of.grid), size, size);
  const glm::dmat3 to_lattice = glm::inverse(view.linear);
  const glm::dvec3 along = to_lattice[2] * view.pixels_per_unit,
                   middle = to_lattice * (glm::dvec3(x + 0.5, y + 0.5, 0) - view.offset),
                   last = glm::dvec3(of.grid.dims - 1);
  constexpr double half = 40, step = 1.0 / 256;
  glm::dvec4 sum(0);
  for (double way = -half; way < half; way += step) {
    const glm::dvec3 at = middle + along * way, inside = glm::clamp(at, glm::dvec3(0), last);
    if (glm::any(glm::greaterThan(glm::abs(at - inside), glm::dvec3(0.5)))) continue;
    double extinction = 0;
    glm::dvec3 light(0);
    for (std::size_t k = 0; k < of.rises.size(); ++k) {
      const auto [colour, opacity] = of.functions[k].evaluate(glm::dot(of.rises[k], glm::dvec4(inside, 1)));
      const double its = -std::log1p(-opacity);
      extinction += its;
      light += its * colour;
    }
    if (!(extinction > 0)) continue;
    sum += (1 - sum.a) * -std::expm1(-extinction * step) * glm::dvec4(light / extinction, 1);
  }
  return sum;
}

Image drawn_as_materials(const LinearFields& of, const Camera& camera, int size) {
  FrameSpec spec;
  spec.shown.mixed = true;
  spec.shown.shading = Shading::none;
  spec.shown.opaque_threshold = 0;
  spec.shown.camera = camera;
  spec.shown.width = spec.shown.height = size;
  SoloCollectives solo;
  const Wiring wiring{solo, nullptr, {}};
  const Layout layout{2, 2, Placement::colocated};
  std::vector<VolumeFrame> frames;
  std::vector<std::vector<float>> voxels;
  Scene scene;
  for (std::size_t k = 0; k < of.rises.size(); ++k) {
    const glm::ivec3 dims = of.grid.dims;
    auto& values = voxels.emplace_back();
    for (int i = 0; i < dims.x * dims.y * dims.z; ++i)
      values.push_back(float(
          glm::dot(of.rises[k], glm::dvec4(i % dims.x, i / dims.x % dims.y, i / (dims.x * dims.y), 1))));
    OpenedVolume volume{of.grid, true, memory_source(of.grid, std::as_bytes(std::span(values)))};
    (k == 0 ? scene : scene.others.emplace_back()) =
        load_scene(volume, needed_along(spec, {true, true, true}), layout, wiring);
    spec.shown.transfer_function = of.functions[k];
    frames.push_back({k, spec});
  }
  Image image;
  Director director;
  director.next_picture = [&] { return std::exchange(frames, {}); };
  director.frame_done = [&](FrameResult&& result) { image = std::move(result.image); };
  render_frames(std::move(scene), layout, {}, std::move(director), wiring, {});
  return image;
}

struct Drawn {
  std::vector<Image> pictures;
  std::uint64_t payloads = 0, bytes = 0;
};

/// `together`: whether frames are given as pictures of several.
Drawn draw(const Case& one, bool together, const Layout& layout, std::uint64_t seed = 0,
           const EngineOptions& engine = {}) {
  constexpr int views = 3;
  SoloCollectives solo;
  const Wiring wiring{solo, nullptr, {.seed = seed, .reorder = true, .max_delay = int(seed % 6)}};
  Drawn drawn;
  FrameSum sum([&](FrameResult&& result, std::size_t) {
    drawn.payloads += result.stats.total().payloads_drawn;
    drawn.bytes += result.stats.total().payload_bytes_received;
    drawn.pictures.push_back(std::move(result.image));
  });
  std::vector<std::vector<VolumeFrame>> wanted;
  for (int view = 0; view < views; ++view) {
    const auto all = picture_of(one, view);
    if (together)
      wanted.push_back(all);
    else
      for (const VolumeFrame& frame : all) wanted.push_back({frame});
  }
  Director director;
  director.next_picture = [&, next = std::size_t{0}]() mutable {
    return next < wanted.size() ? wanted[next++] : std::vector<VolumeFrame>();
  };
  director.frame_done = [&](FrameResult&& result) {
    const auto number = std::size_t(result.spec.frame);
    const std::size_t parts = together ? 1 : one.channels;
    sum.add(std::move(result), number / parts, (number + 1) % parts == 0);
  };
  render_frames(scene_of(one, layout, wiring), layout, {.frames_in_flight = 1 + int(seed % 3)},
                std::move(director), wiring, engine);
  return drawn;
}

}  // namespace

TEST_CASE("channels that are projected together have the bits of those drawn one by one") {
  const std::array cases{Case{.channels = 2},
                         Case{.mode = Mode::minip},
                         Case{.mode = Mode::mean, .channels = 4},
                         Case{.mode = Mode::sum, .channels = 5, .fov = 35},
                         Case{.type = ScalarType::float32, .channels = 4},
                         Case{.type = ScalarType::uint16, .channels = 5, .clipped = true}};
  for (std::size_t k = 0; k < cases.size(); ++k) {
    INFO("case " << k);
    const Drawn apart = draw(cases[k], false, {1, 1});
    REQUIRE(apart.pictures.size() == 3);
    REQUIRE(std::ranges::any_of(apart.pictures.front().rgba, [](float part) { return part > 0.1F; }));
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
      INFO("seed " << seed);
      Layout layout = seed == 5   ? mesh_layout(2, 2, 2, Routing::manhattan)
                      : seed == 4 ? Layout{3, 3, Placement::colocated}
                                  : Layout{1 + int(seed % 3), 1 + int(seed % 2)};
      if (seed == 2) layout.bundle = 4;
      EngineOptions engine{.threads_per_rank = 1 + int(seed % 2)};
      if (seed == 3) engine.keep = 0;
      REQUIRE(draw(cases[k], true, layout, seed, engine).pictures == apart.pictures);
    }
  }
}

TEST_CASE("materials have the same bits for any ranks, and what is seen of one alone has its own") {
  const std::array cases{Case{.mode = Mode::composite, .channels = 2},
                         Case{.type = ScalarType::float32, .mode = Mode::composite, .fov = 35},
                         Case{.mode = Mode::composite, .channels = 5, .clipped = true}};
  for (Case one : cases) {
    const Drawn added = draw(one, true, {1, 1});
    one.mixed = true;
    const Drawn alone = draw(one, true, {1, 1});
    REQUIRE(added.pictures.size() == 3);
    CHECK(added.pictures != alone.pictures);
    CHECK(added.payloads > alone.payloads);
    for (int seed = 1; seed < 4; ++seed) {
      const Layout layout =
          seed == 3 ? mesh_layout(2, 2, 2, Routing::manhattan) : Layout{seed, 3 - seed, Placement::colocated};
      Case other = one;
      other.region_size = 16 + 7 * seed;
      CHECK(draw(other, true, layout, std::uint64_t(seed), {.threads_per_rank = seed}).pictures ==
            alone.pictures);
    }
    one.alone = 1;
    const Drawn with_others = draw(one, true, {1, 1});
    one.mixed = false;
    FrameSpec itself = picture_of(one, 0)[one.channels - 2].spec;
    itself.shown.shading = Shading::phong;
    const auto source = synth_source(names[1], make_grid({31, 33, 29}, one.type));
    CHECK(render_loopback(*source, itself, 1, 1).image == with_others.pictures.front());
  }
}

TEST_CASE("materials are what an integral over all of them shows") {
  LinearFields of{{{2, 1, 6, 0}, {-1, 3, -5, 150}, {1, -2, 3, 60}},
                  {ramp(20, 200, 0.2), ramp(10, 190, 0.35), constant_opacity(0.1, 70)}};
  for (auto& point : of.functions[1].colours) point.srgb = {0.1, point.srgb.x, 0.9};
  constexpr int size = 40;
  for (const Camera& camera : {Camera{}, Camera{.azimuth = 33, .elevation = 21}, Camera{.elevation = 80}}) {
    const Image image = drawn_as_materials(of, camera, size);
    double squares = 0, largest = 0, seen = 0;
    for (int y = 0; y < size; y += 3)
      for (int x = 0; x < size; x += 3)
        for (int c = 0; c < 4; ++c) {
          const double truth = marched(of, camera, size, x, y)[c],
                       error = 255 * (truth - double(image.rgba[std::size_t(4 * (size * y + x) + c)]));
          squares += error * error;
          largest = std::max(largest, std::abs(error));
          seen += truth;
        }
    INFO(largest);
    CHECK(seen > 50);
    CHECK(std::sqrt(squares / (4 * 14 * 14)) < 0.3);
    CHECK(largest < 2);
  }
}

TEST_CASE("channels have one payload a slice") {
  const Case one{.mode = Mode::sum, .channels = 4};
  CHECK(draw(one, false, {1, 1}).payloads > 3 * draw(one, true, {1, 1}).payloads);
  // Renderers keep each one's slices.
  CHECK(draw(one, true, {1, 1}).bytes < draw(one, true, {1, 1}, 0, {.keep = 0}).bytes / 2);
  // What is composited is drawn one by one.
  const Case composited{.mode = Mode::composite, .channels = 2};
  CHECK(draw(composited, false, {1, 1}).payloads == draw(composited, true, {2, 1}).payloads);
  CHECK(draw(composited, false, {1, 1}).pictures == draw(composited, true, {2, 1}).pictures);
}
