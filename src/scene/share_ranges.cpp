#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "net/blocks.hpp"
#include "scene/scene.hpp"
#include "volume/cell_ranges.hpp"
#include "volume/slice_ranges.hpp"

namespace ringsplat {
namespace {

void take_points(std::span<const std::byte> in, Axis axis, VolumeSketch& sketch) {
  const auto [u, v] = in_plane(axis);
  for (std::size_t at = 0; at < in.size();) {
    glm::ivec3 point(0);
    point[static_cast<int>(axis)] = next_value<int>(in, at);
    for (point[v] = 0; point[v] < sketch.points[v]; ++point[v])
      for (point[u] = 0; point[u] < sketch.points[u]; ++point[u])
        sketch.values[sketch.index(point)] = next_value<float>(in, at);
  }
}

}  // namespace

std::vector<float> points_of(const VolumeSketch& sketch, const SliceView& slice) {
  const auto [u, v] = in_plane(slice.axis);
  std::vector<float> points;
  visit_type(slice.type, [&](auto zero) {
    for (int row = 0; row < sketch.points[v]; ++row)
      for (int column = 0; column < sketch.points[u]; ++column) {
        auto value = zero;
        const auto at = std::size_t(sketch.voxel(u, column)) * sizeof value;
        std::memcpy(&value, slice.values_of_row(sketch.voxel(v, row)) + at, sizeof value);
        points.push_back(static_cast<float>(value));
      }
  });
  return points;
}

std::shared_ptr<const VolumeSketch> share_sketch(const std::map<int, SliceStore>& stores, const Grid& grid,
                                                 Axis axis, Collectives& collectives) {
  auto sketch = std::make_shared<VolumeSketch>(grid.dims);
  Block mine;
  for (int layer = 0; layer < sketch->points[static_cast<int>(axis)]; ++layer) {
    const int slice = sketch->voxel(static_cast<int>(axis), layer);
    for (const auto& [gp, store] : stores) {
      if (!store.owns(slice)) continue;
      append(mine, layer);
      for (const float point : points_of(*sketch, store.slice(axis, slice))) append(mine, point);
    }
  }
  // By way of process 0: blocks from each to each would be too many with a thousand processes.
  for (const Block& block : to_process_0(collectives, std::move(mine))) take_points(block, axis, *sketch);
  const Block all = collectives.broadcast(block_of(std::as_bytes(std::span(sketch->values))), 0);
  std::memcpy(sketch->values.data(), all.data(), all.size());
  return sketch;
}

namespace {

constexpr int reach = 2;  ///< slices to either side

struct Head {
  int slice, gp;
  std::uint64_t bytes;
};

/// Gives the ranges of an owned slice to every GP that owns one near it: here at once, elsewhere by `out`.
void give_around(std::map<int, SliceStore>& stores, const Grid& grid, Axis axis, int slice,
                 const Sharing& sharing, std::vector<Block>& out) {
  const SliceStore& owner = stores.at(sharing.dealing.owner_of(slice));
  const auto ranges = std::make_shared<const CellRanges>(owner.slice(axis, slice));
  std::vector<int> told;
  for (int other = slice - reach; other <= slice + reach; ++other) {
    if (other < 0 || other >= grid.slices(axis)) continue;
    const int gp = sharing.dealing.owner_of(other);
    if (std::find(told.begin(), told.end(), gp) != told.end()) continue;
    told.push_back(gp);
    if (sharing.hosts(gp)) {
      stores.at(gp).know_cell_ranges(axis, slice, ranges);
      continue;
    }
    Block& block = out[std::size_t(sharing.process_of_gp[std::size_t(gp)])];
    append(block, Head{slice, gp, ranges->bytes().size()});
    block.insert(block.end(), ranges->bytes().begin(), ranges->bytes().end());
  }
}

void take_given(std::span<const std::byte> in, Axis axis, std::map<int, SliceStore>& stores) {
  for (std::size_t at = 0; at < in.size();) {
    const auto head = next_value<Head>(in, at);
    SliceStore& store = stores.at(head.gp);
    const Grid& grid = store.grid();
    store.know_cell_ranges(
        axis, head.slice,
        std::make_shared<const CellRanges>(grid.type, grid.slice_width(axis), grid.slice_height(axis),
                                           next_bytes(in, at, head.bytes)));
  }
}

}  // namespace

void share_cell_ranges(std::map<int, SliceStore>& stores, const Sharing& sharing) {
  for (const Axis axis : all_axes) {
    std::vector<Block> out(std::size_t(sharing.collectives.processes()));
    for (auto& [gp, store] : stores)
      for (int s = 0; store.keeps(axis) && s < store.grid().slices(axis); ++s)
        if (store.owns(s)) give_around(stores, store.grid(), axis, s, sharing, out);
    for (const Block& block : sharing.collectives.all_to_all(std::move(out))) take_given(block, axis, stores);
  }
}

void share_slice_ranges(std::map<int, SliceStore>& stores, Collectives& collectives) {
  std::vector<SliceRange> mine;
  for (const auto& [gp, store] : stores)
    for (const Axis axis : all_axes)
      for (int s = 0; store.keeps(axis) && s < store.grid().slices(axis); ++s)
        if (store.owns(s)) mine.push_back(slice_range(store.slice(axis, s)));
  std::vector<SliceRange> all;
  for (const auto& one : collectives.all_gather(block_of(std::as_bytes(std::span(mine)))))
    for (std::size_t at = 0; at < one.size();) all.push_back(next_value<SliceRange>(one, at));
  const auto ranges = std::make_shared<const SliceRanges>(all);
  for (auto& [gp, store] : stores) store.know_ranges(ranges);
}

}  // namespace ringsplat
