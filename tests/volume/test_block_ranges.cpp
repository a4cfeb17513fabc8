#include "volume/cell_ranges.hpp"

#include <limits>
#include <random>

#include "support/catch.hpp"

using namespace ringsplat;

namespace {

template <class T>
SliceView view_of(const std::vector<T>& values, int width, int height, ScalarType type) {
  SliceView slice;
  slice.width = width;
  slice.height = height;
  slice.type = type;
  slice.values = reinterpret_cast<const std::byte*>(values.data());
  return slice;
}

}  // namespace

TEST_CASE("every voxel lies in its block's range, and the ends are taken by voxels") {
  constexpr int width = 37, height = 19;
  std::mt19937 random(1);
  std::vector<std::int16_t> values(width * height);
  for (auto& value : values) value = static_cast<std::int16_t>(random());
  const BlockRanges ranges(view_of(values, width, height, ScalarType::int16));
  REQUIRE(ranges.columns() == 3);
  REQUIRE(ranges.rows() == 3);
  std::vector<double> low(9, 1e9), high(9, -1e9);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto block = std::size_t(y / BlockRanges::block_height * 3 + x / BlockRanges::block_width);
      const double value = values[std::size_t(y * width + x)];
      low[block] = std::min(low[block], value);
      high[block] = std::max(high[block], value);
    }
  }
  for (int block = 0; block < 9; ++block) {
    CHECK(ranges.range(block % 3, block / 3).low == low[std::size_t(block)]);
    CHECK(ranges.range(block % 3, block / 3).high == high[std::size_t(block)]);
  }
}

TEST_CASE("not-a-number takes no part in a block's range") {
  constexpr float nothing = std::numeric_limits<float>::quiet_NaN(),
                  infinity = std::numeric_limits<float>::infinity();
  std::vector<float> values(32 * 8, nothing);
  values[20] = 3;
  values[21] = -infinity;
  const BlockRanges ranges(view_of(values, 32, 8, ScalarType::float32));
  CHECK(ranges.range(0, 0).low > ranges.range(0, 0).high);
  CHECK(ranges.range(1, 0).low == -double(infinity));
  CHECK(ranges.range(1, 0).high == 3);
}
