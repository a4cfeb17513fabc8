#include "splat_engine/row_bounds.hpp"

#include <algorithm>
#include <cstdint>

namespace ringsplat {

std::vector<int> row_bounds(const SliceRuns& runs, int height, int most) {
  if (runs.empty()) return {0};
  if (most == 1) return {0, height};
  std::vector<std::int64_t> before{0};  // by row: possibly visible voxels in the rows before
  for (int row = 0; row < height; ++row) {
    std::int64_t voxels = 0;
    for (const ColumnRun& run : runs.of_row(row)) voxels += run.end - run.first;
    before.push_back(before.back() + voxels);
  }
  // Waking a thread costs as much as some hundred voxels.
  constexpr std::int64_t worth_a_thread = 256;
  const auto bands = std::clamp<std::int64_t>(before.back() / worth_a_thread, 1, most);
  std::vector<int> bounds{0};
  for (std::int64_t band = 1; band < bands; ++band) {
    const auto cut = std::lower_bound(before.begin(), before.end(), before.back() * band / bands);
    const int row = int(cut - before.begin());
    if (row > bounds.back() && row < height) bounds.push_back(row);
  }
  bounds.push_back(height);
  return bounds;
}

}  // namespace ringsplat
