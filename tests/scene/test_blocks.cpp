// Volumes that lie in blocks on processes.
#include "ringsplat/base/error.hpp"
#include "scene/dealer.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/random_blocks.hpp"
#include "support/scenes.hpp"
#include "support/thread_collectives.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

std::vector<PlacedBlock> placed(const std::vector<VoxelBox>& boxes) {
  std::vector<PlacedBlock> blocks;
  for (const VoxelBox& box : boxes) blocks.push_back({box, int(blocks.size()) % 3, int(blocks.size()) / 3});
  return blocks;
}

std::vector<std::byte> numbered_voxels(const Grid& grid) {
  std::vector<std::byte> voxels(grid.bytes());
  for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = std::byte((i * i / 7 + 13 * i) % 251);
  return voxels;
}

}  // namespace

TEST_CASE("blocks that cover the grid once are accepted, however it is cut") {
  const Grid grid = make_grid({12, 9, 17});
  Dice dice(1);
  for (int round = 0; round < 50; ++round) {
    const auto boxes = cut_up(whole_box(grid), 1 + dice.below(60), dice);
    CHECK_NOTHROW(check_cover(whole_box(grid), placed(boxes)));
  }
  CHECK_NOTHROW(check_cover(whole_box(grid), placed(lattice_of_blocks(whole_box(grid), {12, 9, 17}))));
}

TEST_CASE("a missing block and blocks that overlap are named, in any decomposition") {
  const Grid grid = make_grid({12, 9, 17});
  Dice dice(2);
  for (int round = 0; round < 50; ++round) {
    auto boxes = cut_up(whole_box(grid), 2 + dice.below(40), dice);
    const std::size_t chosen = std::size_t(dice.below(int(boxes.size())));
    auto holed = boxes;
    holed.erase(holed.begin() + std::ptrdiff_t(chosen));
    CHECK(says(message_of([&] { check_cover(whole_box(grid), placed(holed)); }), "no block covers voxels "));
    const int axis = dice.below(3);
    VoxelBox& grown = boxes[chosen];
    if (grown.first[axis] > 0)
      --grown.first[axis];
    else if (grown.end[axis] < grid.dims[axis])
      ++grown.end[axis];
    else
      continue;
    const std::string message = message_of([&] { check_cover(whole_box(grid), placed(boxes)); });
    INFO(message);
    CHECK(says(message, "overlap"));
    CHECK(says(message, "rank "));
  }
}

TEST_CASE("a hole is named by its voxels and an overlap by its blocks") {
  const Grid grid = make_grid({8, 8, 8});
  const VoxelBox low{{0, 0, 0}, {8, 8, 3}}, high{{0, 0, 4}, {8, 8, 8}};
  CHECK(message_of([&] {
          check_cover(whole_box(grid), placed({low, high}));
        }) ==
        "no block covers voxels 0:8,0:8,3:4; hint: all blocks together must cover the grid, ghosts left out");
  const VoxelBox over{{0, 0, 2}, {8, 8, 8}};
  CHECK(message_of([&] {
          check_cover(whole_box(grid), placed({low, over}));
        }) ==
        "block 0 of rank 0 (0:8,0:8,0:3) and block 0 of rank 1 (0:8,0:8,2:8) overlap; hint: every voxel "
        "belongs to one "
        "block; leave out ghosts");
  CHECK(says(message_of([&] { check_cover(whole_box(grid), {}); }), "no block covers voxels 0:8,0:8,0:8"));
}

TEST_CASE("GPs get the slices of blocks of any shape, order and type, in rounds of bounded size") {
  Dice dice(3);
  for (const ScalarType type :
       {ScalarType::uint8, ScalarType::int16, ScalarType::float32, ScalarType::float64})
    for (const int processes : {1, 2, 3, 5, 8, 13})
      for (const std::size_t round_bytes : {std::size_t{200}, std::size_t{3000}, std::size_t{1} << 20}) {
        const Grid grid = make_grid({11, 7, 19}, type);
        const auto voxels = numbered_voxels(grid);
        std::vector<std::vector<BlockArray>> arrays{std::size_t(processes)};
        for (const VoxelBox& box : cut_up(whole_box(grid), 1 + dice.below(2 * processes), dice))
          arrays[std::size_t(dice.below(processes))].push_back(block_array(grid, voxels, box, dice));
        const int gps = 1 + dice.below(processes + 2);
        std::vector<int> process_of_gp;
        for (int gp = 0; gp < gps; ++gp) process_of_gp.push_back(dice.below(processes));
        CAPTURE(to_string(type), processes, round_bytes, gps);
        std::vector<std::size_t> most(std::size_t(processes), 0);
        std::vector<int> wrong(std::size_t(processes), 0);
        const auto thrown = run_as_processes(processes, [&](ThreadCollectives& all) {
          const auto me = std::size_t(all.process());
          std::vector<VoxelBlock> mine;
          for (const BlockArray& array : arrays[me])
            mine.push_back({array.extent, array.first_voxel(), array.strides});
          check_blocks(grid, mine, all);
          std::map<int, SliceStore> stores;
          for (int gp = 0; gp < gps; ++gp)
            if (process_of_gp[std::size_t(gp)] == all.process())
              stores.emplace(gp, SliceStore(grid, gp, gps, {false, false, true}, false));
          deal_blocks(grid, mine, stores, round_bytes, {gps, process_of_gp, all});
          most[me] = all.most();
          const std::size_t slice = grid.slice_bytes(Axis::z);
          for (auto& [gp, store] : stores)
            for (int z = gp; z < grid.dims.z; z += gps)
              wrong[me] += std::memcmp(store.values(Axis::z, z).data(),
                                       voxels.data() + std::size_t(z) * slice, slice) != 0;
        });
        for (const std::string& text : thrown) CHECK(text.empty());
        for (const int count : wrong) CHECK(count == 0);
        for (const std::size_t bytes : most) CHECK(bytes <= round_bytes);
      }
}

TEST_CASE("a block that is wrong in itself is an error on all processes") {
  const Grid grid = make_grid({8, 8, 8});
  const std::vector<std::byte> voxels(grid.bytes());
  const VoxelBlock whole{whole_box(grid), voxels.data(), x_fastest(grid.dims, 1)};
  VoxelBlock null = whole, outside = whole, empty = whole;
  null.first_voxel = nullptr;
  outside.extent.end.y = 9;
  empty.extent.end.x = 0;
  for (const auto& [bad, words] : {std::pair{null, "block 0 has no voxels"}, std::pair{outside, "block 0: "},
                                   std::pair{empty, "block 0: "}}) {
    const auto thrown = run_as_processes(3, [&](ThreadCollectives& all) {
      check_blocks(grid, all.process() == 1 ? std::vector{bad} : std::vector<VoxelBlock>{}, all);
    });
    for (const std::string& text : thrown) {
      INFO(text);
      CHECK(says(text, words));
      CHECK(says(text, "on rank 1"));
    }
  }
}
