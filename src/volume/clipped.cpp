#include "volume/clipped.hpp"

#include <cstring>
#include <vector>

namespace ringsplat {
namespace {

class ClippedSource final : public VolumeSource {
 public:
  ClippedSource(VolumeSource& full, const VoxelBox& box)
      : full_(full), box_(box), grid_(clipped_grid(full.grid(), box)) {}

  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return full_.concurrent(); }
  Facts facts() const override { return full_.facts(); }
  VolumeNotes notes() const override { return full_.notes(); }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    slice_.resize(full_.grid().slice_bytes(Axis::z));
    for (int k = 0; k < count; ++k) {
      full_.read_slices(box_.first.z + first + k, 1, slice_);
      copy_clipped(full_.grid(), box_, slice_.data(),
                   out.data() + std::size_t(k) * grid_.slice_bytes(Axis::z));
    }
  }

 private:
  VolumeSource& full_;
  VoxelBox box_;
  Grid grid_;
  std::vector<std::byte> slice_;  ///< of the whole volume
};

}  // namespace

void copy_clipped(const Grid& grid, const VoxelBox& box, const std::byte* slice, std::byte* out) {
  const std::size_t scalar = size_of(grid.type), pitch = std::size_t(grid.dims.x) * scalar,
                    row = std::size_t(box.dims().x) * scalar;
  const std::byte* from = slice + std::size_t(box.first.y) * pitch + std::size_t(box.first.x) * scalar;
  for (int y = box.first.y; y < box.end.y; ++y, from += pitch, out += row) std::memcpy(out, from, row);
}

std::unique_ptr<VolumeSource> clipped_source(VolumeSource& full, const VoxelBox& box) {
  check(box, full.grid());
  return std::make_unique<ClippedSource>(full, box);
}

}  // namespace ringsplat
