#include "ringsplat/base/error.hpp"
#include "session/render.hpp"
#include "support/catch.hpp"
#include "support/scenes.hpp"
#include "support/thread_collectives.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

TEST_CASE("a process that is given another grid, layout or view to load is named") {
  constexpr glm::ivec3 dims{8, 8, 12};
  const std::string bytes(std::size_t(dims.x * dims.y * dims.z), 'v');
  FrameSpec spec{.how = Splats{}};
  spec.shown.width = spec.shown.height = 32;
  spec.shown.transfer_function = ringsplat::test::constant_opacity(0.5);
  const auto refusal_of = [&](const auto& change) {
    const auto thrown = run_as_processes(2, [&](ThreadCollectives& collectives) {
      const bool first = collectives.process() == 0;
      Grid grid = make_grid(dims);
      Layout layout{.gps = 2, .renderers = 1};
      FrameSpec mine = spec;
      if (!first) change(grid, layout, mine);
      const auto voxel_bytes = first ? std::as_bytes(std::span(bytes)) : std::span<const std::byte>();
      static_cast<void>(render_image(grid, voxel_bytes, mine, layout, {collectives}));
    });
    CHECK(thrown[1] == thrown[0]);
    return thrown[0];
  };
  CHECK_THAT(
      refusal_of([](Grid& grid, Layout&, FrameSpec&) {
        grid.dims = {16, 16, 24};
      }),
      Catch::Matchers::Contains("rank 1 was given another scene to load: dimensions 16 x 16 x 24, rank 0 has "
                                "8 x 8 x 12"));
  CHECK_THAT(refusal_of([](Grid&, Layout& layout, FrameSpec&) { layout.gps = 3; }),
             Catch::Matchers::Contains("gps 3, rank 0 has 2"));
  CHECK_THAT(refusal_of([](Grid&, Layout& layout, FrameSpec&) { layout.bundle = 4; }),
             Catch::Matchers::Contains("bundle 4, rank 0 has 1"));
  CHECK_THAT(refusal_of([](Grid&, Layout&, FrameSpec& frame) { frame.shown.shading = Shading::none; }),
             Catch::Matchers::Contains("normals left out, rank 0 has kept"));
}
