#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "ringsplat/volume/grid.hpp"
#include "ringsplat/volume/voxel_box.hpp"
#include "volume/slice_dealing.hpp"

namespace ringsplat {

/// One slice as a GP sees it: row-major, u fastest (in_plane(axis)), native scalars.
struct SliceView {
  Axis axis = Axis::z;
  int index = 0;
  int width = 0, height = 0;
  ScalarType type = ScalarType::uint8;
  const std::byte* values = nullptr;       ///< width * height scalars
  const std::uint16_t* normals = nullptr;  ///< width * height quantised normals, or null when unshaded
  int pitch = 0;                           ///< voxels from a row to the next, of a part of a slice; 0: width

  std::size_t row_pitch() const { return std::size_t(pitch > 0 ? pitch : width); }
  const std::byte* values_of_row(int row) const {
    return values + std::size_t(row) * row_pitch() * size_of(type);
  }
  const std::uint16_t* normals_of_row(int row) const {
    return normals == nullptr ? nullptr : normals + std::size_t(row) * row_pitch();
  }
};

/// The smallest and the largest value of a slice, infinities included. Not-a-number is ignored; low > high
/// when the slice has nothing else.
struct SliceRange {
  Axis axis = Axis::z;
  int slice = 0;
  double low = 0, high = 0;
};
/// Of all slices of a volume, other GPs' too, by axis and slice, so that every GP knows which slices a
/// transfer function makes transparent; for each axis all or none.
using SliceRanges = std::array<std::vector<SliceRange>, 3>;

class CellRanges;

/// The slices of every kept axis that a GP owns. They start out zero. Copies share their memory.
class SliceStore {
 public:
  SliceStore() = default;
  /// Takes over the values, not the normals, of axes that `known`, the same GP's store of the same volume,
  /// keeps.
  SliceStore(const Grid& grid, int gp, SliceDealing dealing, std::array<bool, 3> kept_axes, bool with_normals,
             const SliceStore* known = nullptr);

  const Grid& grid() const { return grid_; }
  int gp() const { return gp_; }
  bool keeps(Axis axis) const { return sets_[std::size_t(axis)].values != nullptr; }
  bool has_normals() const { return with_normals_; }
  bool owns(int slice) const { return dealing_.owner_of(slice) == gp_; }

  SliceView slice(Axis axis, int index) const;
  /// The part in the box of slice box.first[axis] + `index`: slice `index` of the volume cropped to the box.
  SliceView slice(Axis axis, int index, const VoxelBox& box) const;
  std::span<std::byte> values(Axis axis, int index) {
    const auto bytes = grid_.slice_bytes(axis);
    return std::span(*sets_[std::size_t(axis)].values).subspan(local(index) * bytes, bytes);
  }
  /// Empty when unshaded.
  std::span<std::uint16_t> normals(Axis axis, int index) {
    if (!with_normals_) return {};
    const auto voxels = grid_.slice_voxels(axis);
    return std::span(*sets_[std::size_t(axis)].normals).subspan(local(index) * voxels, voxels);
  }

  /// Takes what pack_columns() made for this GP as row z of its slices of the axis.
  void unpack_columns(Axis axis, int z, std::span<const std::byte> in);

  /// The part of the volume within which normals were made: their differences are one-sided at its faces.
  const VoxelBox& normals_within() const { return normals_within_; }
  void know_normals_within(const VoxelBox& box) { normals_within_ = box; }

  /// Bytes a GP needs for its slices: what `info` predicts and the store allocates.
  static std::uint64_t bytes_needed(const Grid& grid, int gp, SliceDealing dealing,
                                    std::array<bool, 3> kept_axes, bool with_normals);
  std::uint64_t allocated_bytes() const;  ///< levels included

  /// A reduced volume's slices, of the same GP, for frames that are undersampled by `factor`.
  void add_level(int factor, SliceStore level) { levels_[factor] = std::move(level); }
  /// This store for factor 1. Throws RunError when there is no such level.
  const SliceStore& level(int factor) const;

  /// A segmentation's labels of all voxels, of 8 bits, with as many levels; null: there is none.
  void know_labels(std::shared_ptr<const SliceStore> labels) { labels_ = std::move(labels); }
  const SliceStore* labels() const { return labels_.get(); }

  /// The value ranges of all slices of an axis, other GPs' too; none when unknown.
  void know_ranges(std::shared_ptr<const SliceRanges> ranges) { ranges_ = std::move(ranges); }
  const std::vector<SliceRange>& ranges(Axis axis) const { return (*ranges_)[std::size_t(axis)]; }

  /// The ranges of the cells of an owned slice, or of one next to it or next but one.
  void know_cell_ranges(Axis axis, int index, std::shared_ptr<const CellRanges> ranges) {
    cell_ranges_[std::size_t(axis)][index] = std::move(ranges);
  }
  /// Whether those of an axis were told; a GP without slices needs none.
  bool knows_cell_ranges(Axis axis) const {
    return dealing_.owned_count(grid_.slices(axis), gp_) == 0 || !cell_ranges_[std::size_t(axis)].empty();
  }
  /// Null when unknown.
  const CellRanges* cell_ranges(Axis axis, int index) const {
    const auto& of_axis = cell_ranges_[std::size_t(axis)];
    const auto found = of_axis.find(index);
    return found == of_axis.end() ? nullptr : found->second.get();
  }

 private:
  struct Set {
    std::shared_ptr<std::vector<std::byte>> values;
    std::shared_ptr<std::vector<std::uint16_t>> normals;
  };
  std::size_t local(int index) const { return std::size_t(dealing_.place_of(index)); }

  Grid grid_;
  int gp_ = 0;
  SliceDealing dealing_;
  bool with_normals_ = false;
  VoxelBox normals_within_;
  std::array<Set, 3> sets_;
  std::map<int, SliceStore> levels_;  ///< by factor
  std::shared_ptr<const SliceStore> labels_;
  std::shared_ptr<const SliceRanges> ranges_ = std::make_shared<const SliceRanges>();
  std::array<std::map<int, std::shared_ptr<const CellRanges>>, 3> cell_ranges_;  ///< by axis and slice
};

/// The exchange by which GPs that read z slices get their x and y slices: appends, for each slice of `axis`
/// (x or y) that GP `gp` owns, the one line of the z slice that lies in it: its values, then its normals when
/// `normals` is not empty. `values` and `normals` are the whole z slice, grid.slice_voxels(Axis::z) of each.
void pack_columns(const Grid& grid, Axis axis, int gp, SliceDealing dealing,
                  std::span<const std::byte> values, std::span<const std::uint16_t> normals,
                  std::vector<std::byte>& out);

}  // namespace ringsplat
