// What a rank makes of messages and blocks that no rank of this build sends. tests/fuzz makes many more.
#include <cmath>

#include "node/empty_space.hpp"
#include "node/splat_engine.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/base/thread_team.hpp"
#include "ringsplat/net/blocks.hpp"
#include "ringsplat/node/load.hpp"
#include "ringsplat/record/trace.hpp"
#include "ringsplat/volume/slice_ranges.hpp"
#include "support/catch.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const Grid grid = make_grid({6, 5, 4});

FrameSpec small_frame() {
  FrameSpec spec;
  spec.width = spec.height = 32;
  spec.region_size = 16;
  spec.transfer_function = ramp(20, 255, 0.9);
  spec.dealt_to = 1;
  return spec;
}

/// Process 1 of two; process 0 says the same block whenever it broadcasts, and another when all gather.
class OddCompany final : public Collectives {
 public:
  OddCompany(Block said, Block gathered) : said_(std::move(said)), gathered_(std::move(gathered)) {}
  explicit OddCompany(const Block& all) : OddCompany(all, all) {}
  int process() const override { return 1; }
  int processes() const override { return 2; }
  std::vector<Block> all_to_all(std::vector<Block> out) override {
    out[0] = gathered_;
    return out;
  }
  std::vector<Block> all_gather(const Block& mine) override { return {gathered_, mine}; }
  Block broadcast(Block, int) override { return said_; }
  std::vector<int> absent(double) override { return {}; }

 private:
  Block said_, gathered_;
};

std::map<int, SliceStore> one_store() {
  std::map<int, SliceStore> stores;
  stores.emplace(0, SliceStore(grid, 0, 1, {true, true, true}, false));
  return stores;
}

template <class F>
std::string run_error_of(F&& f) {
  try {
    f();
  } catch (const RunError& e) {
    return e.what();
  }
  return "none";
}

}  // namespace

TEST_CASE("a Renderer refuses the payload of a step that its traversal does not have") {
  const auto frame = make_splat_frame(small_frame(), grid, 1, 1);
  ThreadTeam alone;
  const auto painter = make_splat_painter(0, 1, alone);
  painter->begin_frame(frame);
  for (const int step : {-1, frame->geometry.slices, 1 << 30})
    CHECK_THAT(run_error_of([&] { painter->begin({step, 0, {}}); }), Catch::Matchers::Contains("step"));
}

TEST_CASE("a GP refuses a frame for which it has no slices or no normals") {
  const auto engine = make_splat_engine(grid, Layout{1, 1}, std::move(one_store().at(0)), 1, {}, {});
  EmptySpace empty_space;
  ThreadTeam alone;
  const SliceStore only_x(grid, 0, 1, {true, false, false}, true);
  const auto encode = [&](const FrameSpec& spec, const SliceStore& store) {
    return run_error_of(
        [&] { make_splat_encoder(make_splat_frame(spec, grid, 1, 1), 1, store, empty_space, alone); });
  };
  CHECK_THAT(encode(small_frame(), one_store().at(0)), Catch::Matchers::Contains("normals"));
  CHECK_THAT(encode(small_frame(), only_x), Catch::Matchers::Contains("axis, whose slices were not loaded"));
}

TEST_CASE("an engine refuses a frame of another number than its message has, or that cannot be") {
  const auto engine = make_splat_engine(grid, Layout{1, 1}, std::move(one_store().at(0)), 1, {}, {});
  FrameSpec spec = small_frame();
  const auto plan = [&](std::int64_t frame) {
    return run_error_of([&] { static_cast<void>(engine->plan({frame, encode(spec)})); });
  };
  CHECK(plan(0) == "none");
  CHECK_THAT(plan(3), Catch::Matchers::Contains("frame 0 in a message about frame 3"));
  spec.frame = 1;
  spec.width = -5;
  CHECK_THAT(plan(1), Catch::Matchers::Contains("that cannot be"));
}

TEST_CASE("blocks of a wrong size are refused while a volume is opened and dealt") {
  // Whoever gathers no texts agrees that there is no error.
  OddCompany agreeing(Block(7), {});
  CHECK_THAT(run_error_of([&] { open_everywhere(agreeing, [] { return synth_source("ball", grid); }); }),
             Catch::Matchers::Contains("7 bytes"));
  OddCompany short_blocks(Block(7));
  auto stores = one_store();
  CHECK_THAT(run_error_of([&] { share_slice_ranges(stores, short_blocks); }),
             Catch::Matchers::Contains("too short"));
  CHECK_THAT(run_error_of([&] { value_range(stores, short_blocks); }),
             Catch::Matchers::Contains("too short"));
  // The sums that process 0 sends are more than were asked for, or fewer.
  const ValueRange range = [] {
    ValueRange r;
    r.low = 0;
    r.high = 255;
    r.finite = 1;
    return r;
  }();
  CHECK_THAT(run_error_of([&] { histogram(stores, range, 64, short_blocks); }),
             Catch::Matchers::Contains("7 bytes"));
  OddCompany long_blocks(Block(8000));
  CHECK_THAT(run_error_of([&] { histogram(stores, range, 64, long_blocks); }),
             Catch::Matchers::Contains("8000 bytes"));
}

TEST_CASE("ranges of slices and values that cannot be are refused") {
  auto stores = one_store();
  for (const SliceRange& odd :
       {SliceRange{Axis(7), 0, 0, 1}, SliceRange{Axis::z, 4, 0, 1}, SliceRange{Axis::x, -1, 0, 1}}) {
    OddCompany company(block_of_value(odd));
    CHECK_THAT(run_error_of([&] { share_slice_ranges(stores, company); }),
               Catch::Matchers::Contains("does not have"));
  }
  ValueRange odd;
  odd.finite = 3;
  odd.low = NAN;
  odd.high = 5;
  OddCompany company(block_of_value(odd));
  CHECK_THAT(run_error_of([&] { value_range(stores, company); }), Catch::Matchers::Contains("range of its"));
}

TEST_CASE("records of what a rank did are refused when no rank can have done it") {
  for (const int fault : {0, 1, 2, 3}) {
    Bytes sent;
    append(sent, 0.0);  // the clock's time, offset and uncertainty, and that it is common
    append(sent, 0.0);
    append(sent, 0.0);
    append(sent, true);
    append(sent, NodeId{fault == 1 ? Role(9) : Role::gp, 0});
    append(sent, false);
    append(sent, std::uint64_t{1});
    Span span;
    if (fault == 2) span.begin = INFINITY;
    if (fault == 3) span.activity = Activity(200);
    append(sent, span);
    append(sent, std::uint64_t{0});
    // Process 0 gathers.
    class Gathering final : public Collectives {
     public:
      explicit Gathering(const Bytes& other) : other_(other.begin(), other.end()) {}
      int process() const override { return 0; }
      int processes() const override { return 2; }
      std::vector<Block> all_to_all(std::vector<Block> out) override {
        out[1] = other_;
        return out;
      }
      std::vector<Block> all_gather(const Block& mine) override { return {mine, mine}; }
      Block broadcast(Block block, int) override { return block; }
      std::vector<int> absent(double) override { return {}; }

     private:
      Block other_;
    } gathering(sent);
    const Trace trace;
    const std::string error = run_error_of([&] { static_cast<void>(trace.gather(gathering)); });
    if (fault == 0)
      CHECK(error == "none");
    else
      CHECK_THAT(error, Catch::Matchers::Contains("rank 1 sent a broken record"));
  }
}
