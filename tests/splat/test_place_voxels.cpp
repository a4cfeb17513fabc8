#include "splat/voxel_sum.hpp"

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <random>

#include "splat/splat.hpp"
#include "support/catch.hpp"
#include "support/vector_targets.hpp"

using namespace ringsplat;

namespace {

/// What a splat of the voxel adds with weight 1.
std::array<float, 4> premultiplied(const VoxelColour& voxel, double weight) {
  const auto opacity = static_cast<float>(double(voxel.opacity) * weight);
  const float scale = opacity * (1.0F / 65535.0F);
  return {float(voxel.red) * scale, float(voxel.green) * scale, float(voxel.blue) * scale, opacity};
}

std::vector<PackedVoxel> random_voxels(std::size_t count, std::mt19937& random) {
  std::uniform_real_distribution<float> share(0, 1);
  std::vector<float> rgba(4 * count);
  for (float& value : rgba) value = share(random);
  std::fill_n(rgba.begin(), 4, 0.0F);
  std::fill_n(rgba.begin() + 4, 4, 1.0F);
  std::vector<PackedVoxel> voxels(count);
  pack(rgba.data(), count, voxels.data());
  return voxels;
}

AlignedSlice slice_of(int step) {
  AlignedSlice slice;
  slice.step_x = step;
  slice.opacity_weight = 0.59681;
  slice.reach_x = slice.reach_y = 0;
  slice.covered = {{0, 0}};
  return slice;
}

/// A region of a row of pixels, all −1, for a kernel that covers its anchor and no other pixel.
struct OneRow {
  std::vector<float> pixels = std::vector<float>(4 * 300, -1.0F);
  std::vector<std::uint64_t> filled = std::vector<std::uint64_t>(6, 0);
  VoxelRows places() {
    VoxelRows to;
    to.buffer.origin = pixels.data();
    to.buffer.width = 300;
    to.buffer.height = 1;
    to.filled = filled.data();
    to.row_words = 6;
    to.left = 40;
    to.x = 9;
    return to;
  }
};

DrawnBlocks place_block(std::uint64_t mask, const std::vector<PackedVoxel>& voxels, int step, OneRow& row) {
  const VoxelRun block{0, 0, mask};
  VoxelRows to = row.places();
  return place_voxels(slice_of(step), to,
                      VoxelRuns{reinterpret_cast<const std::byte*>(&block), 1, voxels.data()}, 1000);
}

bool is_set(const OneRow& row, int pixel) {
  return (row.filled[std::size_t(pixel + 40) / 64] >> (pixel + 40) % 64 & 1) != 0;
}

}  // namespace

TEST_CASE("voxels go to their places premultiplied, with the same bits by every instruction set") {
  std::mt19937 random(5);
  const auto voxels = random_voxels(64, random);
  for (const int step : {1, 2, 4}) {
    for (const std::uint64_t mask : {~std::uint64_t{0}, std::uint64_t{1} << 63, std::uint64_t{0b1011},
                                     (std::uint64_t(random()) << 32) | random() | 3}) {
      std::vector<float> expected(4 * 300, -1.0F);
      std::size_t next = 0;
      std::array<bool, 300> filled{};
      for (int bit = 0; bit < 64; ++bit) {
        if ((mask >> bit & 1) == 0) continue;
        const auto colour = premultiplied(unpack(voxels[next++]), 0.59681);
        for (int pixel = 9 + bit * step; pixel < 9 + (bit + 1) * step; ++pixel) {
          std::copy(colour.begin(), colour.end(), expected.begin() + 4 * pixel);
          filled[std::size_t(pixel)] = true;
        }
      }
      for (const auto& target : vector_targets()) {
        use_vector_target(target);
        INFO(target << ", " << step << " pixels a voxel, mask " << mask);
        // No more than the mask's voxels may be read: a sanitizer would tell.
        const std::vector<PackedVoxel> given(voxels.begin(), voxels.begin() + std::popcount(mask));
        OneRow row;
        const DrawnBlocks placed = place_block(mask, given, step, row);
        CHECK(placed.counts.drawn == given.size());
        CHECK(std::memcmp(row.pixels.data(), expected.data(), expected.size() * sizeof(float)) == 0);
        for (int pixel = 0; pixel < 300; ++pixel) REQUIRE(is_set(row, pixel) == filled[std::size_t(pixel)]);
      }
      use_vector_target("");
    }
  }
}

TEST_CASE("a voxel whose opacity no footprint gives goes to its place as nothing") {
  for (const float opacity : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                              -std::numeric_limits<float>::infinity(), 1e30F}) {
    PackedVoxel voxel{{}, {65535, 1, 2}};
    std::memcpy(voxel.opacity, &opacity, sizeof opacity);
    for (const auto& target : vector_targets()) {
      use_vector_target(target);
      OneRow row;
      place_block(1, std::vector{voxel}, 1, row);
      for (int k = 0; k < 4; ++k) CHECK(row.pixels[std::size_t(4 * 9 + k)] == 0);
    }
    use_vector_target("");
  }
}

TEST_CASE("placing stops behind the block that has the last voxel asked for") {
  std::mt19937 random(7);
  const auto voxels = random_voxels(12, random);
  const std::array<VoxelRun, 3> blocks{{{0, 0, 0xF}, {0, 64, 0xF}, {0, 128, 0xF}}};
  for (const auto& [most, expected] : {std::pair{1, 1}, std::pair{4, 1}, std::pair{5, 2}, std::pair{99, 3}}) {
    OneRow row;
    VoxelRows to = row.places();
    const DrawnBlocks placed = place_voxels(
        slice_of(1), to, VoxelRuns{reinterpret_cast<const std::byte*>(blocks.data()), 3, voxels.data()},
        std::uint64_t(most));
    CHECK(placed.blocks == std::uint32_t(expected));
    CHECK(placed.counts.drawn + placed.counts.clipped == 4 * std::uint64_t(expected));
    CHECK(is_set(row, 9 + 128) == (expected == 3));
  }
}
