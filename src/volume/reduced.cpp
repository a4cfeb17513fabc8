#include "ringsplat/volume/reduced.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

/// Sums of the voxels that a reduced slice's voxels are means of.
class Means {
 public:
  explicit Means(std::size_t voxels) : sums_(voxels), counts_(voxels) {}
  void add(std::size_t voxel, double value) {
    if (std::isnan(value)) return;
    sums_[voxel] += value;
    ++counts_[voxel];
  }
  template <class T>
  T mean(std::size_t voxel) const {
    if constexpr (std::is_floating_point_v<T>)
      return counts_[voxel] == 0 ? std::numeric_limits<T>::quiet_NaN() : static_cast<T>(sums_[voxel] / counts_[voxel]);
    else
      return static_cast<T>(std::llround(sums_[voxel] / counts_[voxel]));
  }

 private:
  std::vector<double> sums_;
  std::vector<int> counts_;
};

class ReducedSource final : public VolumeSource {
 public:
  ReducedSource(VolumeSource& full, const Reduction& reduction)
      : full_(full), reduction_(reduction), grid_(reduced_grid(full.grid(), reduction)), slice_(full.grid().slice_bytes(Axis::z)) {}

  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return full_.concurrent(); }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const std::size_t bytes = grid_.slice_bytes(Axis::z);
    for (int k = 0; k < count; ++k) {
      const auto part = out.subspan(std::size_t(k) * bytes, bytes);
      visit_type(grid_.type, [&](auto zero) {
        using T = decltype(zero);
        if (reduction_.prefilter)
          average<T>(first + k, part);
        else
          pick<T>(first + k, part);
      });
    }
  }

 private:
  template <class T>
  static T at(const std::byte* values, std::size_t index) {
    T value;
    std::memcpy(&value, values + index * sizeof(T), sizeof(T));
    return value;
  }

  template <class T>
  void pick(int z, std::span<std::byte> out) {
    full_.read_slices(z * reduction_.factor, 1, slice_);
    std::size_t to = 0;
    for (int y = 0; y < grid_.dims.y; ++y) {
      const std::size_t row = std::size_t(y * reduction_.factor) * std::size_t(full_.grid().dims.x);
      for (int x = 0; x < grid_.dims.x; ++x, ++to) {
        const T value = at<T>(slice_.data(), row + std::size_t(x * reduction_.factor));
        std::memcpy(out.data() + to * sizeof(T), &value, sizeof(T));
      }
    }
  }

  template <class T>
  void average(int z, std::span<std::byte> out) {
    const glm::ivec3 dims = full_.grid().dims;
    const int factor = reduction_.factor;
    Means means(grid_.slice_voxels(Axis::z));
    for (int full_z = z * factor; full_z < std::min((z + 1) * factor, dims.z); ++full_z) {
      full_.read_slices(full_z, 1, slice_);
      std::size_t from = 0;
      for (int y = 0; y < dims.y; ++y) {
        const std::size_t row = std::size_t(y / factor) * std::size_t(grid_.dims.x);
        for (int x = 0; x < dims.x; ++x, ++from) means.add(row + std::size_t(x / factor), static_cast<double>(at<T>(slice_.data(), from)));
      }
    }
    for (std::size_t k = 0; k < grid_.slice_voxels(Axis::z); ++k) {
      const T value = means.mean<T>(k);
      std::memcpy(out.data() + k * sizeof(T), &value, sizeof(T));
    }
  }

  VolumeSource& full_;
  Reduction reduction_;
  Grid grid_;
  std::vector<std::byte> slice_;  ///< of the full volume
};

}  // namespace

Grid reduced_grid(const Grid& grid, const Reduction& reduction) {
  if (reduction.factor < 1)
    throw InputError(fmt::format("--undersample {} is no number of voxels", reduction.factor), "use 1, 2 or 4");
  Grid reduced = grid;
  reduced.dims = (grid.dims + (reduction.factor - 1)) / reduction.factor;
  reduced.spacing = grid.spacing * double(reduction.factor);
  if (reduction.prefilter) reduced.origin += grid.direction * (grid.spacing * (0.5 * (reduction.factor - 1)));
  return reduced;
}

std::unique_ptr<VolumeSource> reduced_source(VolumeSource& full, const Reduction& reduction) {
  return std::make_unique<ReducedSource>(full, reduction);
}

}  // namespace ringsplat
