#include "support/catch.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// The largest difference between a picture and the middle of a larger one.
double difference_from_middle(const Image& picture, const Image& large) {
  const int left = (large.width - picture.width) / 2, top = (large.height - picture.height) / 2;
  double largest = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      for (int k = 0; k < 4; ++k)
        largest = std::max(
            largest, std::abs(double(picture.pixel(x, y)[k]) - double(large.pixel(x + left, y + top)[k])));
  return largest;
}

}  // namespace

TEST_CASE("a close view reads only the voxels that it shows, and shows what a larger picture does") {
  const auto source = synth_source("ball", make_grid({41, 36, 38}));
  FrameSpec large = oblique_view(240, 210, 32);
  large.shown.camera.zoom = 1;
  FrameSpec close = large;
  close.shown.width = 48;
  close.shown.height = 42;
  close.shown.camera.zoom = 5;
  const FrameResult whole = render_loopback(*source, large, 2, 2),
                    part = render_loopback(*source, close, 2, 2);
  REQUIRE(whole.stats.total().voxels_outside == 0);
  const NodeStats seen = part.stats.total(), all = whole.stats.total();
  CHECK(seen.voxels_outside > 0);
  CHECK(seen.visible_voxels < all.visible_voxels / 2);
  CHECK(seen.visible_voxels + seen.voxels_outside >= all.visible_voxels);
  CHECK(difference_from_middle(part.image, whole.image) < 1e-5);
}
