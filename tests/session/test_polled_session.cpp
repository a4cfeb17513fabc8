#include <numeric>
#include <stdexcept>
#include <vector>

#include "ringsplat/session/session.hpp"
#include "session/render_frames.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

constexpr int side = 12;

Grid cube() {
  Grid grid;
  grid.dims = glm::ivec3(side);
  return grid;
}

/// Values that grow along x, y and z at different rates.
std::vector<std::uint8_t> values(int along_x, int along_y, int along_z) {
  std::vector<std::uint8_t> made;
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) made.push_back(std::uint8_t(along_x * x + along_y * y + along_z * z));
  return made;
}

FrameSpec frame_of(Session& session) {
  FrameSpec frame{.how = Splats{}};
  frame.shown.width = frame.shown.height = 32;
  frame.shown.transfer_function = session.transfer_function("auto");
  return frame;
}

Session committed(const std::vector<std::uint8_t>& voxels, const SessionOptions& options = {}) {
  Session session({}, std::nullopt, options);
  session.set_grid(cube());
  session.add_block(whole_box(cube()), voxels.data());
  session.commit();
  return session;
}

}  // namespace

TEST_CASE("what a session's poll throws ends its frame, and the session can be used on") {
  const auto voxels = values(9, 5, 3);
  int left = -1, calls = 0;
  SessionOptions options;
  options.poll = [&] {
    ++calls;
    if (left >= 0 && left-- == 0) throw std::runtime_error("enough");
  };
  Session session = committed(voxels, options);
  const FrameSpec frame = frame_of(session);
  for (left = 0; left < 4; ++left) {
    const int turns = left;
    CHECK_THROWS_WITH(session.render(frame), "enough");
    left = turns;
  }
  left = -1;
  Session plain = committed(voxels);
  CHECK(session.render(frame) == plain.render(frame));
  CHECK(calls > 10);
}

TEST_CASE("an updated block may lie in memory in another order") {
  const auto first = values(9, 5, 3), turned = values(3, 5, 9);
  Session session = committed(first);
  const Image before = session.render(frame_of(session));
  session.update_block(0, turned.data(), z_fastest(cube().dims, 1));  // the same values, x and z exchanged
  session.commit();
  CHECK(session.render(frame_of(session)) == before);
  session.update_block(0, first.data());  // with the strides of the last update
  session.commit();
  CHECK(!(session.render(frame_of(session)) == before));
}

TEST_CASE("a session's frames come with what is known of them") {
  const auto voxels = values(9, 5, 3);
  Session session = committed(voxels);
  CHECK(SessionParts::values(session).range.high == 17 * (side - 1));
  std::vector<FrameResult> results;
  SessionParts::render(session, {frame_of(session), frame_of(session)},
                       [&](FrameResult&& result) { results.push_back(std::move(result)); });
  REQUIRE(results.size() == 2);
  CHECK(results[1].stats.total().splats_drawn > 0);
  CHECK(results[0].image == results[1].image);
}
