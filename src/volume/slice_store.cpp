#include "volume/slice_store.hpp"

#include <fmt/format.h>

#include <cstring>
#include <stdexcept>

#include "base/process.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/scalars.hpp"

namespace ringsplat {
namespace {

/// Copies, for each slice of the axis (x or y) that the GP owns, the line of a z slice that lies in it. Each
/// copied line starts `stride` bytes after the one before.
void gather(const std::byte* values, std::size_t bytes, const Grid& grid, Axis axis, int gp,
            SliceDealing dealing, std::byte* out, std::size_t stride) {
  const bool columns = axis == Axis::x;
  const std::size_t row = std::size_t(grid.dims.x) * bytes, along = columns ? row : bytes,
                    across = columns ? bytes : row;
  const int length = grid.slice_width(axis), lines = dealing.owned_count(grid.slices(axis), gp);
  // Copies columns by blocks that fit the first-level cache, since one cache line serves many columns.
  const int block = columns ? 64 : length;
  for (int first = 0; first < length; first += block)
    for (int k = 0; k < lines; ++k)
      copy_row(bytes, values + std::size_t(dealing.slice_at(gp, k)) * across + std::size_t(first) * along,
               std::int64_t(along), std::min(block, length - first),
               out + std::size_t(k) * stride + std::size_t(first) * bytes);
}

/// Large pages must be asked for before the memory is used.
template <class T>
std::shared_ptr<std::vector<T>> allocated(std::size_t count) {
  auto values = std::make_shared<std::vector<T>>();
  values->reserve(count);
  prefer_huge_pages(values->data(), count * sizeof(T));
  values->resize(count);
  return values;
}

}  // namespace

SliceStore::SliceStore(const Grid& grid, int gp, SliceDealing dealing, std::array<bool, 3> kept_axes,
                       bool with_normals, const SliceStore* known)
    : grid_(grid), gp_(gp), dealing_(dealing), with_normals_(with_normals), normals_within_(whole_box(grid)) {
  if (dealing.gps < 1 || dealing.bundle < 1 || gp < 0 || gp >= dealing.gps)
    throw std::invalid_argument("a slice store needs 0 <= gp < gps and bundles of slices");
  for (const Axis axis : all_axes) {
    if (!kept_axes[std::size_t(axis)]) continue;
    const auto voxels = std::size_t(dealing.owned_count(grid.slices(axis), gp)) * grid.slice_voxels(axis);
    auto& set = sets_[std::size_t(axis)];
    set.values = known != nullptr && known->keeps(axis) ? known->sets_[std::size_t(axis)].values
                                                        : allocated<std::byte>(voxels * size_of(grid.type));
    if (with_normals) set.normals = allocated<std::uint16_t>(voxels);
  }
}

SliceView SliceStore::slice(Axis axis, int index) const {
  const auto& set = sets_[std::size_t(axis)];
  return {axis,
          index,
          grid_.slice_width(axis),
          grid_.slice_height(axis),
          grid_.type,
          set.values->data() + local(index) * grid_.slice_bytes(axis),
          with_normals_ ? set.normals->data() + local(index) * grid_.slice_voxels(axis) : nullptr};
}

SliceView SliceStore::slice(Axis axis, int index, const VoxelBox& box) const {
  const auto [u, v] = in_plane(axis);
  SliceView part = slice(axis, box.first[static_cast<int>(axis)] + index);
  part.pitch = part.width;
  const std::size_t corner = std::size_t(box.first[v]) * part.row_pitch() + std::size_t(box.first[u]);
  part.index = index;
  part.width = box.dims()[u];
  part.height = box.dims()[v];
  part.values += corner * size_of(part.type);
  if (part.normals != nullptr) part.normals += corner;
  return part;
}

void SliceStore::unpack_columns(Axis axis, int z, std::span<const std::byte> in) {
  const auto line = std::size_t(grid_.slice_width(axis)), value_bytes = line * size_of(grid_.type),
             normal_bytes = with_normals_ ? line * sizeof(std::uint16_t) : 0;
  const std::byte* from = in.data();
  for (int k = 0; k < dealing_.owned_count(grid_.slices(axis), gp_); ++k) {
    const int s = dealing_.slice_at(gp_, k);
    std::memcpy(values(axis, s).data() + std::size_t(z) * value_bytes, from, value_bytes);
    from += value_bytes;
    if (with_normals_) std::memcpy(normals(axis, s).data() + std::size_t(z) * line, from, normal_bytes);
    from += normal_bytes;
  }
}

std::uint64_t SliceStore::bytes_needed(const Grid& grid, int gp, SliceDealing dealing,
                                       std::array<bool, 3> kept_axes, bool with_normals) {
  const std::uint64_t per_voxel = size_of(grid.type) + (with_normals ? sizeof(std::uint16_t) : 0);
  std::uint64_t bytes = 0;
  for (const Axis axis : all_axes)
    if (kept_axes[std::size_t(axis)])
      bytes +=
          std::uint64_t(dealing.owned_count(grid.slices(axis), gp)) * grid.slice_voxels(axis) * per_voxel;
  return bytes;
}

std::uint64_t SliceStore::allocated_bytes() const {
  std::uint64_t bytes = 0;
  for (const auto& [values, normals] : sets_) {
    if (values) bytes += values->capacity();
    if (normals) bytes += normals->capacity() * sizeof(std::uint16_t);
  }
  for (const auto& [factor, level] : levels_) bytes += level.allocated_bytes();
  if (labels_) bytes += labels_->allocated_bytes();
  return bytes;
}

const SliceStore& SliceStore::level(int factor) const {
  if (factor == 1) return *this;
  const auto found = levels_.find(factor);
  if (found == levels_.end())
    throw RunError(fmt::format("a frame is undersampled by {}, but no such level was loaded", factor),
                   "load it with --undersample");
  return found->second;
}

void pack_columns(const Grid& grid, Axis axis, int gp, SliceDealing dealing,
                  std::span<const std::byte> values, std::span<const std::uint16_t> normals,
                  std::vector<std::byte>& out) {
  const auto line = std::size_t(grid.slice_width(axis));
  const auto value_bytes = line * size_of(grid.type);
  const auto stride = value_bytes + (normals.empty() ? 0 : line * sizeof(std::uint16_t));
  const auto at = out.size();
  out.resize(at + std::size_t(dealing.owned_count(grid.slices(axis), gp)) * stride);
  gather(values.data(), size_of(grid.type), grid, axis, gp, dealing, out.data() + at, stride);
  if (!normals.empty())
    gather(std::as_bytes(normals).data(), sizeof(std::uint16_t), grid, axis, gp, dealing,
           out.data() + at + value_bytes, stride);
}

}  // namespace ringsplat
