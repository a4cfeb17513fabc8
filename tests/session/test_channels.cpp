// Volumes on one grid whose projections are drawn as one frame: their sum has the bits that it has of
// pictures that are drawn one by one.
#include <fmt/format.h>

#include <algorithm>
#include <array>

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
};

TransferFunction function_of(std::size_t channel, const Case& one) {
  const double unit = one.type == ScalarType::float32 ? 1.0 / 255 : 1,
               from = one.mode == Mode::minip ? -60 : 20, step = double(channel);
  TransferFunction tf = ramp(unit * (from + 12 * step), unit * (190 + 15 * step), 0.6);
  for (auto& point : tf.colours)
    for (int c = 0; c < 3; ++c) point.srgb[c] *= (int(channel) + c) % 3 == 0 ? 0.9 : 0.2;
  return tf;
}

/// A view of the channels, the last of the volumes first.
std::vector<VolumeFrame> picture_of(const Case& one, int view) {
  FrameSpec spec;
  spec.shown.mode = one.mode;
  spec.shown.shading = Shading::none;
  spec.shown.camera = {.azimuth = 17.0 * view, .elevation = 21, .fov = one.fov};
  spec.shown.width = spec.shown.height = 56;
  spec.division.region_size = 24;
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
