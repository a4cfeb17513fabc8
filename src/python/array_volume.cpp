#include "python/array_volume.hpp"

#include <cstring>

namespace ringsplat::python {
namespace {

class ArraySource final : public VolumeSource {
 public:
  explicit ArraySource(const ArrayVolume& volume) : volume_(volume) { check(volume.grid, "the array"); }
  const Grid& grid() const override { return volume_.grid; }
  bool concurrent() const override { return true; }
  VolumeNotes notes() const override { return volume_.notes; }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const glm::ivec3& dims = volume_.grid.dims;
    std::byte* to = out.data();
    for (int z = first; z < first + count; ++z)
      for (int y = 0; y < dims.y; ++y, to += row_bytes_)
        read_row(volume_.first_voxel + z * volume_.strides.z + y * volume_.strides.y, to);
  }

 private:
  void read_row(const std::byte* from, std::byte* to) const {
    if (volume_.strides.x == std::int64_t(scalar_)) {
      std::memcpy(to, from, row_bytes_);
      return;
    }
    for (int x = 0; x < volume_.grid.dims.x; ++x, from += volume_.strides.x, to += scalar_)
      std::memcpy(to, from, scalar_);
  }

  ArrayVolume volume_;
  std::size_t scalar_ = size_of(volume_.grid.type), row_bytes_ = scalar_ * std::size_t(volume_.grid.dims.x);
};

}  // namespace

std::unique_ptr<VolumeSource> array_source(const ArrayVolume& volume) {
  return std::make_unique<ArraySource>(volume);
}

}  // namespace ringsplat::python
