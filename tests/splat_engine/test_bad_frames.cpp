// Frames and payloads that no rank of this build sends. tests/fuzz makes many more.
#include "base/thread_team.hpp"
#include "classify/empty_space.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "ringsplat/base/error.hpp"
#include "splat_engine/splat_engine.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const Grid grid = make_grid({6, 5, 4});

FrameSpec small_frame() {
  FrameSpec spec{.how = Splats{}};
  spec.shown.width = spec.shown.height = 32;
  spec.division.region_size = 16;
  spec.shown.transfer_function = ramp(20, 255, 0.9);
  spec.division.dealt_to = 1;
  return spec;
}

const SliceStore empty_store(grid, 0, 1, {true, true, true}, false);

}  // namespace

TEST_CASE("a Renderer refuses the payload of a step that its traversal does not have") {
  const auto frame = std::make_shared<SplatFrame>(small_frame(), make_geometry(small_frame(), grid), 1, 1);
  ThreadTeam alone;
  const auto painter = make_splat_painter(0, alone);
  painter->begin_frame(frame);
  for (const int step : {-1, frame->geometry.slices, 1 << 30})
    CHECK_THAT(message_of<RunError>([&] {
                 painter->begin({step, 0, {}});
               }),
               Catch::Matchers::Contains("step"));
}

TEST_CASE("a GP refuses a frame for which it has no slices or no normals") {
  EmptySpace empty_space;
  ThreadTeam alone;
  const SliceStore only_x(grid, 0, 1, {true, false, false}, true);
  const auto encode = [&](const FrameSpec& spec, const SliceStore& store) {
    return message_of<RunError>([&] {
      make_splat_encoder(std::make_shared<SplatFrame>(spec, make_geometry(spec, grid), 1, 1), 1, store,
                         empty_space, alone);
    });
  };
  CHECK_THAT(encode(small_frame(), empty_store), Catch::Matchers::Contains("normals"));
  FrameSpec clipped = small_frame();
  clipped.shown.clip = VoxelBox{{0, 0, 0}, {6, 4, 4}};
  const SliceStore lit(grid, 0, 1, {true, true, true}, true);
  CHECK(encode(small_frame(), lit).empty());
  CHECK_THAT(encode(clipped, lit), Catch::Matchers::Contains("another clip box"));
  CHECK_THAT(encode(small_frame(), only_x), Catch::Matchers::Contains("axis, whose slices were not loaded"));
}

TEST_CASE("an engine refuses a frame of another number than its message has, or that cannot be") {
  SplatEngine engine({.grid = grid, .slices = std::make_shared<const SliceStore>(empty_store)});
  FrameSpec spec = small_frame();
  const auto plan = [&](std::int64_t frame) {
    return message_of<RunError>([&] {
      static_cast<void>(engine.plan({frame, encode(std::vector{FrameOfVolume{0, spec}})}));
    });
  };
  CHECK(plan(0).empty());
  CHECK_THAT(plan(3), Catch::Matchers::Contains("frame 0 in a message about frame 3"));
  spec.frame = 1;
  spec.shown.width = -5;
  CHECK_THAT(plan(1), Catch::Matchers::Contains("that cannot be"));
  spec = small_frame();
  spec.frame = 2;
  spec.shown.clip = VoxelBox{{0, 0, 0}, {6, 1 << 30, 4}};
  CHECK_THAT(plan(2), Catch::Matchers::Contains("that cannot be: the clip box's y part"));
}
