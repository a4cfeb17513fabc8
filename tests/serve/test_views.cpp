#include "serve/views.hpp"

#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::serve;

namespace {

ViewerOptions small_volume() {
  ViewerOptions options;
  options.volume.grid.dims = {8, 8, 8};
  options.initial.shown.width = options.initial.shown.height = 64;
  return options;
}

ViewMessage view_of(const ViewerOptions& options, int volume, bool moving = false) {
  ViewMessage view{.moving = moving, .scene = options.initial};
  view.scene.frame = volume;
  return view;
}

/// Draws what is wanted next. Returns its volume, and whether nothing finer will come of it.
std::pair<int, bool> draw(Views& views) {
  const auto wish = views.next();
  REQUIRE((wish && wish->level));
  views.begun();
  const bool done = views.drawn(*wish);
  views.took(*wish->level, 0.001);
  return {wish->view.message.scene.frame, done};
}

}  // namespace

TEST_CASE("A view at rest is drawn until it has been shown at best, and again when the volume is renewed") {
  const ViewerOptions options = small_volume();
  Views views(options);
  CHECK_FALSE(views.next());
  views.put(view_of(options, 0, true));
  CHECK_FALSE(draw(views).second);
  CHECK_FALSE(views.next()->level);  // one picture of a view that moves
  views.put(view_of(options, 0));
  int pictures = 1;
  while (!draw(views).second) ++pictures;
  CHECK(pictures <= 3);
  CHECK_FALSE(views.next()->level);
  views.renewed({}, false);
  CHECK(views.next()->level);
}

TEST_CASE("Only a view that looks otherwise is newer") {
  const ViewerOptions options = small_volume();
  Views views(options);
  views.put(view_of(options, 0));
  const Views::View first = views.next()->view;
  views.put(view_of(options, 0, true));
  CHECK_FALSE(views.has_newer(first));
  views.put(view_of(options, 1));
  CHECK(views.has_newer(first));
}

TEST_CASE("Of two volumes that are compared each has its place among those that ranks hold") {
  ViewerOptions options = small_volume();
  options.initial.shown.transfer_function = {.colours = {{0, glm::dvec3(0.0)}, {1, glm::dvec3(1.0)}},
                                             .opacities = {{0, 0}, {1, 1}}};
  options.channels.resize(2);
  options.initial.channels.resize(2, {.window = {0, 1}});
  for (ShownChannel& channel : options.channels) channel.own[Mode::composite] = options.initial.shown;
  Views views(options);
  ViewMessage view = view_of(options, 5);
  view.scene.compared = 3;
  CHECK_FALSE(views.can_draw(view.scene));
  views.put(ViewMessage(view));
  views.loaded({{5, 3}, std::vector<ValueRange>(4)});
  CHECK(views.can_draw(view.scene));
  REQUIRE(views.next());
  const auto frames = views.frames(0);
  REQUIRE(frames.size() == 4);
  for (std::size_t k = 0; k < 4; ++k) {
    CHECK(frames[k].volume == k);
    CHECK((frames[k].joins == Joins::below) == (k == 2));
  }
  views.not_loaded(3);
  CHECK_FALSE(views.next());
}

TEST_CASE("Two pictures of a view that moves are drawn at a level that keeps the target for both") {
  ViewerOptions options = small_volume();
  options.volume.grid.dims = {64, 64, 64};
  options.frame.how = Sheets{};
  Views views(options);
  views.loaded({{0, 1}, std::vector<ValueRange>(2)});
  double a_rough_second = 0;  // a single picture at best keeps the target, two do not
  const auto level_of = [&](bool pair) {
    int level = 0;
    for (int k = 0; k < (pair ? 1 : 40); ++k) {
      ViewMessage view = view_of(options, 0, true);
      view.scene.shown.camera.azimuth = k + 100 * pair;
      if (pair) view.scene.compared = 1;
      views.put(std::move(view));
      const auto wish = views.next();
      level = *wish->level;
      const auto rough = [&](int at) {
        return rough_seconds(views.frames(at).front().spec, options.volume.grid.dims);
      };
      if (a_rough_second == 0)
        a_rough_second = 0.7 * options.target_seconds / rough(int(views.levels().size()) - 1);
      views.drawn(*wish);
      views.took(level, a_rough_second * rough(level) * (pair ? 2 : 1));
    }
    return level;
  };
  const int best = int(views.levels().size()) - 1;
  CHECK(level_of(false) == best);
  CHECK(level_of(true) < best);
}

TEST_CASE("Of every volume of a series that was loaded one picture is drawn before the newest is wanted") {
  const ViewerOptions options = small_volume();
  Views views(options);
  views.put(view_of(options, 1));
  CHECK(views.next()->view.message.scene.frame == 1);
  views.loaded({{1}, {{}}});
  for (const int volume : {2, 3}) views.put(view_of(options, volume));
  CHECK(draw(views).first == 1);
  CHECK(views.next()->view.message.scene.frame == 3);
  views.not_loaded(3);
  CHECK_FALSE(views.next());
}

TEST_CASE(
    "Of coarse data reduced levels are drawn, nothing of it is final, and the whole volume is drawn after "
    "it") {
  ViewerOptions options = small_volume();
  options.volume.grid.dims = {64, 64, 64};
  Views views(options);
  views.loaded({{0}, options.volume.ranges, Reduction{2}});
  views.put(view_of(options, 0));
  for (auto wish = views.next(); wish->level; wish = views.next()) {
    CHECK(views.levels()[std::size_t(*wish->level)].undersample > 1);
    CHECK_FALSE(views.frames(*wish->level).front().spec.shown.reduction.prefilter);
    CHECK_FALSE(draw(views).second);
  }
  views.loaded({{0}, options.volume.ranges});
  while (!draw(views).second) continue;
  CHECK_FALSE(views.next()->level);
}
