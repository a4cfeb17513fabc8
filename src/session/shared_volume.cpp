#include "session/shared_volume.hpp"

#include <algorithm>
#include <new>

#include "ringsplat/base/error.hpp"
#include "session/render_frames.hpp"

namespace ringsplat {
namespace {

// Rows of this size stay in a core's cache while they are packed, sent and placed; larger ones take up to
// twice as long (tests/session/bench_commit.cpp).
constexpr std::size_t round_bytes = std::size_t{1} << 16;

std::string why_wrong(const Grid& grid, const Layout& layout, const Wiring& wiring) {
  try {
    check(grid, "the grid");
    check_wiring(layout, wiring);
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

std::map<int, SliceStore> empty_slices(const Grid& grid, SliceDealing dealing, const std::vector<int>& mine) {
  std::map<int, SliceStore> slices;
  for (const int gp : mine) slices.emplace(gp, SliceStore(grid, gp, dealing, {false, false, true}, false));
  return slices;
}

bool contains(const std::vector<int>& all, const std::vector<int>& some) {
  return std::all_of(some.begin(), some.end(),
                     [&](int one) { return std::find(all.begin(), all.end(), one) != all.end(); });
}

bool covers(const LoadOptions& made, const LoadOptions& needed) {
  for (const Axis axis : all_axes)
    if (needed.kept_axes[std::size_t(axis)] && !made.kept_axes[std::size_t(axis)]) return false;
  const bool reduced = std::any_of(needed.factors.begin(), needed.factors.end(), [](int f) { return f > 1; });
  return contains(made.factors, needed.factors) && (!reduced || made.prefilter == needed.prefilter) &&
         (!needed.with_normals || (made.with_normals && made.clip == needed.clip)) &&
         (!needed.with_cell_ranges || made.with_cell_ranges);
}

/// What is needed now, and of what is made already all that can be kept beside it.
LoadOptions joined(const LoadOptions& made, LoadOptions needed) {
  for (const Axis axis : all_axes) needed.kept_axes[std::size_t(axis)] |= made.kept_axes[std::size_t(axis)];
  if (!needed.with_normals) needed.clip = made.clip;
  needed.with_normals |= made.with_normals;
  needed.with_cell_ranges |= made.with_cell_ranges;
  for (const int factor : made.factors)
    if (!contains(needed.factors, {factor}) && (factor == 1 || made.prefilter == needed.prefilter))
      needed.factors.push_back(factor);
  return needed;
}

}  // namespace

void SharedVolume::replace(const Grid& grid, const std::vector<VoxelBlock>& blocks) {
  Collectives& all = wiring_.collectives;
  agree(all, why_wrong(grid, layout_, wiring_));
  require_same_scene(grid, {}, layout_, wiring_);
  check_blocks(grid, blocks, all);
  const auto gps = gps_by_process(layout_, wiring_);
  scene_.reset();
  values_.reset();
  std::string error;
  if (!grid_ || facts_of(*grid_) != facts_of(grid)) {
    grid_.reset();
    slices_.clear();
    try {
      slices_ = empty_slices(grid, dealing_of(layout_), gps[std::size_t(all.process())]);
    } catch (const std::bad_alloc&) {
      error = "there is no memory for the volume's slices; hint: use more ranks on more machines";
    }
  }
  agree(all, error);
  grid_ = grid;
  deal_blocks(grid, blocks, slices_, dealing_of(layout_), gps, round_bytes, all);
}

const ValueStatistics& SharedVolume::values() {
  if (!values_) values_ = share_values(slices_, *grid_, {}, wiring_.collectives);
  return *values_;
}

Scene SharedVolume::scene_for(const LoadOptions& needed) {
  if (!scene_ || !covers(made_, needed)) {
    made_ = scene_ ? joined(made_, needed) : needed;
    scene_.reset();
    scene_ = deal_scene_again(*grid_, slices_, made_, dealing_of(layout_), gps_by_process(layout_, wiring_),
                              wiring_.collectives);
  }
  return *scene_;
}

}  // namespace ringsplat
