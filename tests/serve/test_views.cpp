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
  views.renewed(false);
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

TEST_CASE("Of every volume of a series that was loaded one picture is drawn before the newest is wanted") {
  const ViewerOptions options = small_volume();
  Views views(options);
  views.put(view_of(options, 1));
  CHECK(views.next()->view.message.scene.frame == 1);
  views.loaded(1);
  for (const int volume : {2, 3}) views.put(view_of(options, volume));
  CHECK(draw(views).first == 1);
  CHECK(views.next()->view.message.scene.frame == 3);
  views.not_loaded(3);
  CHECK_FALSE(views.next());
}
