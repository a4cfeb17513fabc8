// Blocks that no rank of this build sends while a volume is dealt. tests/fuzz makes many more.
#include <cmath>

#include "net/blocks.hpp"
#include "ringsplat/base/error.hpp"
#include "scene/scene.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/scenes.hpp"
#include "volume/slice_ranges.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const Grid grid = make_grid({6, 5, 4});

/// Process 1 of two. Process 0 broadcasts one block always, and contributes another to every gather.
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

/// What a process says of its values before it counts them.
struct Head {
  ValueRange range;
  std::uint64_t fill;
  std::uint64_t flags;
};

Head head_of(double low, double high) {
  Head head{};
  head.range.low = low;
  head.range.high = high;
  head.range.finite = 3;
  return head;
}

std::map<int, SliceStore> one_store() {
  std::map<int, SliceStore> stores;
  stores.emplace(0, SliceStore(grid, 0, 1, {true, true, true}, false));
  return stores;
}

}  // namespace

TEST_CASE("blocks of a wrong size are refused while a volume is opened and dealt") {
  // A gather without texts means that there is no error.
  OddCompany agreeing(Block(7), {});
  CHECK_THAT(
      message_of<RunError>([&] { open_everywhere(agreeing, [] { return synth_source("ball", grid); }); }),
      Catch::Matchers::Contains("7 bytes"));
  OddCompany short_blocks(Block(7));
  auto stores = one_store();
  CHECK_THAT(message_of<RunError>([&] { share_slice_ranges(stores, short_blocks); }),
             Catch::Matchers::Contains("too short"));
  CHECK_THAT(message_of<RunError>([&] { share_values(stores, grid, {}, short_blocks); }),
             Catch::Matchers::Contains("7 bytes"));
  // Process 0 sends more sums than requested, or fewer.
  for (const std::size_t bytes : {7U, 8000U}) {
    OddCompany company{Block(bytes), block_of_value(head_of(0, 255))};
    CHECK_THAT(message_of<RunError>([&] { share_values(stores, grid, {}, company); }),
               Catch::Matchers::Contains(std::to_string(bytes) + " bytes instead of"));
  }
}

TEST_CASE("ranges of slices and values that cannot be are refused") {
  auto stores = one_store();
  for (const SliceRange& odd :
       {SliceRange{Axis(7), 0, 0, 1}, SliceRange{Axis::z, 4, 0, 1}, SliceRange{Axis::x, -1, 0, 1}}) {
    OddCompany company(block_of_value(odd));
    CHECK_THAT(message_of<RunError>([&] { share_slice_ranges(stores, company); }),
               Catch::Matchers::Contains("does not have"));
  }
  OddCompany company(block_of_value(head_of(NAN, 5)));
  CHECK_THAT(message_of<RunError>([&] { share_values(stores, grid, {}, company); }),
             Catch::Matchers::Contains("range of its"));
}
