#include <cstring>

#include "base/byte_stream.hpp"
#include "net/blocks.hpp"
#include "ringsplat/base/error.hpp"
#include "scene/load.hpp"

namespace ringsplat {
namespace {

/// The points of a slice of `axis`, row by row.
void append_points(const VolumeSketch& sketch, const SliceView& slice, Axis axis, Block& out) {
  const auto [u, v] = in_plane(axis);
  visit_type(slice.type, [&](auto zero) {
    using T = decltype(zero);
    for (int row = 0; row < sketch.points[v]; ++row)
      for (int column = 0; column < sketch.points[u]; ++column) {
        T value;
        std::memcpy(
            &value,
            slice.values_of_row(sketch.voxel(v, row)) + std::size_t(sketch.voxel(u, column)) * sizeof(T),
            sizeof(T));
        append(out, static_cast<float>(value));
      }
  });
}

void take_points(std::span<const std::byte> in, Axis axis, VolumeSketch& sketch) {
  const auto [u, v] = in_plane(axis);
  for (std::size_t at = 0; at < in.size();) {
    glm::ivec3 point(0);
    int& layer = point[static_cast<int>(axis)];
    bool whole = take(in, at, layer) && layer >= 0 && layer < sketch.points[static_cast<int>(axis)];
    for (point[v] = 0; whole && point[v] < sketch.points[v]; ++point[v])
      for (point[u] = 0; whole && point[u] < sketch.points[u]; ++point[u])
        whole = take(in, at, sketch.values[sketch.index(point)]);
    if (!whole) throw RunError("a rank sent voxels that fit no slice", "all ranks must run the same build");
  }
}

}  // namespace

std::shared_ptr<const VolumeSketch> share_sketch(const std::map<int, SliceStore>& stores, const Grid& grid,
                                                 Axis axis, Collectives& collectives) {
  auto sketch = std::make_shared<VolumeSketch>(grid.dims);
  Block mine;
  for (int layer = 0; layer < sketch->points[static_cast<int>(axis)]; ++layer) {
    const int slice = sketch->voxel(static_cast<int>(axis), layer);
    for (const auto& [gp, store] : stores) {
      if (!store.owns(slice)) continue;
      append(mine, layer);
      append_points(*sketch, store.slice(axis, slice), axis, mine);
    }
  }
  // By way of process 0: blocks from each to each would be too many with a thousand processes.
  std::vector<Block> out(std::size_t(collectives.processes()));
  out.front() = std::move(mine);
  for (const Block& block : collectives.all_to_all(std::move(out))) take_points(block, axis, *sketch);
  const Block all = collectives.broadcast(block_of(std::as_bytes(std::span(sketch->values))), 0);
  if (all.size() != sketch->values.size() * sizeof(float))
    throw RunError("rank 0 told of other voxels than it was sent", "all ranks must run the same build");
  std::memcpy(sketch->values.data(), all.data(), all.size());
  return sketch;
}

}  // namespace ringsplat
