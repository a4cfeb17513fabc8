#include <fmt/format.h>

#include "support/catch.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// Frames from a list; every third becomes unwanted after a number of calls of unwanted().
struct Browsing {
  std::vector<FrameSpec> specs;
  int patience = 0;
  std::map<std::int64_t, int> questions = {};
  std::vector<std::pair<std::int64_t, Image>> done = {};

  static bool turns_away_from(std::int64_t frame) { return frame % 3 == 1; }
  Director director() {
    Director director =
        director_of(specs, [this](FrameResult&& r) { done.emplace_back(r.spec.frame, std::move(r.image)); });
    director.unwanted = [this](const FrameSpec& spec) {
      return turns_away_from(spec.frame) && ++questions[spec.frame] > patience;
    };
    return director;
  }
};

std::vector<FrameSpec> turning_views(int count) {
  std::vector<FrameSpec> specs;
  specs.resize(std::size_t(count));
  for (int k = 0; k < count; ++k) {
    FrameSpec& spec = specs[std::size_t(k)];
    spec.how = Splats{};
    spec.shown.camera = {.azimuth = 52.0 * k, .elevation = 21};
    spec.shown.width = spec.shown.height = 48 + 8 * (k % 2);
    spec.division.region_size = 16;
    spec.shown.transfer_function = ramp(20, 255, 0.5);
  }
  return specs;
}

}  // namespace

TEST_CASE("dropped frames end at any moment, and the others have the bits they have alone") {
  const auto source = synth_source("ball", make_grid({17, 15, 16}));
  const auto specs = turning_views(9);
  std::vector<Image> alone;
  for (const auto& spec : specs) alone.push_back(render_loopback(*source, spec, 1, 1).image);
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const int gps = std::array{1, 2, 3, 4, 6}[seed % 5];
    const Layout layout =
        seed % 4 == 3 ? mesh_layout(2, 2, 2, Routing::manhattan) : Layout{gps, 1 + int(seed % 3)};
    Browsing browsing{.specs = specs, .patience = int(7 * seed % 90)};
    INFO(fmt::format("seed {}", seed));
    render_directed(
        *source, {}, layout, browsing.director(), {.seed = seed, .reorder = true, .max_delay = int(seed % 6)},
        {.frames_in_flight = 1 + int(seed % 3), .slots = 1 + int(seed % 2), .send_ahead = int(seed / 3 % 3)});
    std::size_t kept = 0;
    for (const auto& [frame, image] : browsing.done) {
      kept += !Browsing::turns_away_from(frame);
      REQUIRE(image == alone[std::size_t(frame)]);
    }
    REQUIRE(kept == 6);
    if (browsing.patience == 0) REQUIRE(browsing.done.size() == 6);
  }
}

TEST_CASE("a sum of volumes is dropped as one, and the others have the bits of their parts") {
  const std::array<const char*, 3> names{"ball", "shell", "box"};
  const Grid grid = make_grid({17, 15, 16});
  const auto views = turning_views(9);
  std::vector<std::vector<VolumeFrame>> pictures(views.size());
  std::vector<Image> sums(views.size());
  for (std::size_t k = 0; k < views.size(); ++k)
    for (std::size_t part = 0; part <= k % 3; ++part) {
      pictures[k].push_back({(k + 2 * part) % 3, views[k]});
      const Image alone =
          render_loopback(*synth_source(names[pictures[k].back().volume], grid), views[k], 1, 1).image;
      if (part == 0) sums[k] = alone;
      for (std::size_t p = 0; part > 0 && p < alone.rgba.size(); ++p) sums[k].rgba[p] += alone.rgba[p];
    }
  for (std::size_t k = 0; k < sums.size(); ++k)
    for (float& value : sums[k].rgba)
      if (pictures[k].size() > 1) value = std::min(value, 1.0F);
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Layout layout = seed % 4 == 3 ? mesh_layout(2, 2, 2, Routing::manhattan)
                                        : Layout{1 + int(seed % 4), 1 + int(seed % 3)};
    SoloCollectives solo;
    const Wiring wiring{solo, nullptr, {.seed = seed, .reorder = true, .max_delay = int(seed % 6)}};
    const auto loaded = [&](const char* name) {
      OpenedVolume volume{grid, true, synth_source(name, grid)};
      return load_scene(volume, {}, layout, wiring);
    };
    Scene scene = loaded(names[0]);
    scene.others = {loaded(names[1]), loaded(names[2])};
    Browsing browsing{.specs = {}, .patience = int(7 * seed % 90)};
    Director director = browsing.director();
    director.next_picture = [&, next = std::size_t{0}]() mutable {
      return next < pictures.size() ? pictures[next++] : std::vector<VolumeFrame>();
    };
    INFO(fmt::format("seed {}", seed));
    render_frames(std::move(scene), layout, {.frames_in_flight = 1 + int(seed % 3)}, std::move(director),
                  wiring);
    for (const auto& [picture, image] : browsing.done) REQUIRE(image == sums[std::size_t(picture)]);
    REQUIRE(std::count_if(browsing.done.begin(), browsing.done.end(),
                          [](const auto& one) { return !Browsing::turns_away_from(one.first); }) == 6);
    if (browsing.patience == 0) REQUIRE(browsing.done.size() == 6);
  }
}

TEST_CASE("a dropped frame costs its tokens, not its splats") {
  const auto source = synth_source("ball", make_grid({33, 33, 33}));
  auto specs = turning_views(2);
  Browsing browsing{.specs = specs};
  std::vector<std::int64_t> done;
  Director director = browsing.director();
  director.frame_done = [&](FrameResult&& r) {
    done.push_back(r.spec.frame);
    CHECK_FALSE(r.stats.dropped);
  };
  render_directed(*source, {}, {2, 2}, std::move(director));
  CHECK(done == std::vector<std::int64_t>{0});
}

TEST_CASE("a director may have nothing for a while") {
  const auto source = synth_source("ball", make_grid({17, 15, 16}));
  const auto specs = turning_views(3);
  int polls = 0;
  std::size_t given = 0, done = 0;
  Director director{[&]() -> std::optional<FrameSpec> {
                      return ++polls % 5 == 0 && given < specs.size() ? std::optional(specs[given++])
                                                                      : std::nullopt;
                    },
                    [&](FrameResult&&) { ++done; }};
  director.may_come = [&] { return given < specs.size(); };
  render_directed(*source, {}, {2, 1}, std::move(director), {.reorder = true, .max_delay = 40});
  CHECK(done == specs.size());
}
