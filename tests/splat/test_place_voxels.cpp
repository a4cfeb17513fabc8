#include "splat/place_voxels.hpp"

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <random>

#include "ringsplat/splat/encode.hpp"
#include "splat/painter_kernels.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

/// What a splat of the voxel adds with weight 1.
std::array<float, 4> premultiplied(const VoxelColour& voxel, double weight) {
  const auto opacity = static_cast<float>(double(voxel.opacity) * weight);
  const float scale = opacity * (1.0F / 65535.0F);
  return {float(voxel.red) * scale, float(voxel.green) * scale, float(voxel.blue) * scale, opacity};
}

template <class Voxel>
std::vector<Voxel> random_voxels(std::size_t count, std::mt19937& random) {
  std::uniform_real_distribution<float> share(0, 1);
  std::vector<float> rgba(4 * count);
  for (float& value : rgba) value = share(random);
  std::fill_n(rgba.begin(), 4, 0.0F);
  std::fill_n(rgba.begin() + 4, 4, 1.0F);
  std::vector<Voxel> voxels(count);
  pack(rgba.data(), count, voxels.data());
  return voxels;
}

AlignedSlice slice_of(int step) {
  AlignedSlice slice;
  slice.step_x = step;
  slice.opacity_weight = 0.59681;
  return slice;
}

}  // namespace

TEMPLATE_TEST_CASE("voxels go to their places premultiplied, with the same bits by every instruction set", "",
                   FloatVoxel, HalfVoxel, ByteVoxel) {
  std::mt19937 random(5);
  const auto voxels = random_voxels<TestType>(64, random);
  for (const int step : {1, 2, 4}) {
    for (const std::uint64_t mask : {~std::uint64_t{0}, std::uint64_t{1} << 63, std::uint64_t{0b1011},
                                     (std::uint64_t(random()) << 32) | random() | 3}) {
      std::vector<float> expected(4 * 300, -1.0F);
      std::size_t next = 0;
      for (int bit = 0; bit < 64; ++bit) {
        if ((mask >> bit & 1) == 0) continue;
        const auto colour = premultiplied(unpack(voxels[next++]), 0.59681);
        for (int copy = 0; copy < step; ++copy)
          std::copy(colour.begin(), colour.end(), expected.begin() + 4 * (9 + bit * step + copy));
      }
      for (const auto& target : vector_targets()) {
        use_vector_target(target);
        INFO(target << ", " << step << " pixels a voxel, mask " << mask);
        // No more than the mask's voxels may be read: a sanitizer would tell.
        const std::vector<TestType> given(voxels.begin(), voxels.begin() + std::popcount(mask));
        std::vector<float> row(4 * 300, -1.0F);
        place_voxels(slice_of(step), mask, given.data(), 9, row.data());
        CHECK(std::memcmp(row.data(), expected.data(), row.size() * sizeof(float)) == 0);
      }
      use_vector_target("");
    }
  }
}

TEST_CASE("a voxel whose opacity no footprint gives goes to its place as nothing") {
  for (const float opacity : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                              -std::numeric_limits<float>::infinity(), 1e30F}) {
    FloatVoxel voxel{{}, {65535, 1, 2}};
    std::memcpy(voxel.opacity, &opacity, sizeof opacity);
    for (const auto& target : vector_targets()) {
      use_vector_target(target);
      std::vector<float> row(4, -1.0F);
      place_voxels(slice_of(1), 1, &voxel, 0, row.data());
      for (const float value : row) CHECK(value == 0);
    }
    use_vector_target("");
  }
}
