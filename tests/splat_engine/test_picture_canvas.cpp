#include "engine_parts/frame_engine.hpp"
#include "net/message.hpp"
#include "splat_engine/splat_engine.hpp"
#include "support/catch.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

TEST_CASE("pixels for which no tile comes are empty, whatever their memory held") {
  FrameSpec spec = oblique_view(48, 48, 16);
  spec.division.dealt_to = 2;
  const auto frame = std::make_shared<SplatFrame>(spec, make_geometry(spec, make_grid({9, 9, 9})), 1, 2);
  std::vector<int> tiles;
  for (int tile = 0; tile < int(frame->plan.tiles.size()); ++tile)
    if (frame->plan.tiles[std::size_t(tile)].renderer != FramePlan::nobody) tiles.push_back(tile);
  REQUIRE(tiles.size() > 2);
  for (int round = 0; round < 8; ++round) {
    Image picture;
    const auto canvas = make_picture_canvas(frame->number, frame->shown, {frame, &frame->geometry},
                                            [&](std::int64_t, Image&& image) { picture = std::move(image); });
    // All tiles, whose values then remain in freed memory, and next a single tile.
    const std::size_t some = round % 2 == 0 ? tiles.size() : 1;
    float expected = 0;
    for (std::size_t k = 0; k < some; ++k) {
      const std::size_t values = frame->plan.tiles[std::size_t(tiles[k])].bytes / sizeof(float);
      const std::vector<float> tile(values, 7.0F);
      canvas->take(tiles[k], std::as_bytes(std::span(tile)));
      expected += 7.0F * float(values);
    }
    canvas->finish();
    float sum = 0;
    for (const float value : picture.rgba) sum += value;
    CHECK(sum == expected);
  }
}
