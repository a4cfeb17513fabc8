#include "ringsplat/volume/reduced.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <type_traits>

#include "ringsplat/base/error.hpp"
#include "volume/clipped.hpp"
#include "volume/forwarding_source.hpp"
#include "volume/scalars.hpp"

namespace ringsplat {
namespace {

constexpr int taps = 4;
/// Cubic interpolation half-way between voxels. It blurs no more than the next level's kernels do anyway and,
/// like a mean, removes what that level cannot hold.
constexpr std::array<double, taps> weights{-1.0 / 16, 9.0 / 16, 9.0 / 16, -1.0 / 16};

/// Half the voxels along each axis: its grid is halved, too.
class HalvedSource final : public ForwardingSource {
 public:
  using ForwardingSource::ForwardingSource;

  int layer_depth() const override { return reduced_layer_depth(source_.layer_depth(), {2, true}); }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    const std::size_t bytes = grid().slice_bytes(Axis::z);
    for (int k = 0; k < count; ++k)
      visit_type(grid().type, [&](auto zero) {
        filter<decltype(zero)>(first + k, out.subspan(std::size_t(k) * bytes, bytes));
      });
  }

 private:
  /// The full volume's slice nearest to z.
  const std::byte* slice(int z) {
    const int nearest = std::clamp(z, 0, source_.grid().dims.z - 1);
    const auto [kept, is_new] = kept_.try_emplace(nearest, source_.grid().slice_bytes(Axis::z));
    if (is_new) source_.read_slices(nearest, 1, kept->second);
    return kept->second.data();
  }

  template <class T>
  void filter(int z, std::span<std::byte> out) {
    // The next slice shares some of its taps with this one.
    std::erase_if(kept_, [z](const auto& kept) { return kept.first < 2 * z - 1 || kept.first > 2 * z + 2; });
    std::array<const std::byte*, taps> slices;
    for (int k = 0; k < taps; ++k) slices[std::size_t(k)] = slice(2 * z - 1 + k);
    const glm::ivec3 dims = source_.grid().dims;
    std::vector<double> column(std::size_t(dims.x));
    auto* to = reinterpret_cast<T*>(out.data());
    for (int y = 0; y < grid().dims.y; ++y) {
      std::fill(column.begin(), column.end(), 0.0);
      for (int i = 0; i < taps * taps; ++i) {
        const std::size_t row =
            std::size_t(std::clamp(2 * y - 1 + i % taps, 0, dims.y - 1)) * std::size_t(dims.x);
        const double weight = weights[std::size_t(i / taps)] * weights[std::size_t(i % taps)];
        for (std::size_t x = 0; x < column.size(); ++x)
          column[x] += weight * number(static_cast<double>(load<T>(slices[std::size_t(i / taps)], row + x)));
      }
      for (int x = 0; x < grid().dims.x; ++x, ++to) {
        double sum = 0;
        for (int k = 0; k < taps; ++k)
          sum += weights[std::size_t(k)] * column[std::size_t(std::clamp(2 * x - 1 + k, 0, dims.x - 1))];
        *to = limited<T>(sum, cell<T>(slices, x, y, z));
      }
    }
  }

  /// The numbers among the up to eight voxels that one voxel stands for.
  struct Cell {
    double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity(),
           sum = 0;
    int count = 0;
  };

  template <class T>
  Cell cell(const std::array<const std::byte*, taps>& slices, int x, int y, int z) const {
    const glm::ivec3 dims = source_.grid().dims;
    Cell cell;
    for (int k = 2 * z; k < std::min(2 * z + 2, dims.z); ++k) {
      for (int j = 2 * y; j < std::min(2 * y + 2, dims.y); ++j) {
        for (int i = 2 * x; i < std::min(2 * x + 2, dims.x); ++i) {
          const double value = number(static_cast<double>(load<T>(
              slices[std::size_t(k - 2 * z + 1)], std::size_t(j) * std::size_t(dims.x) + std::size_t(i))));
          if (std::isnan(value)) continue;
          cell.low = std::min(cell.low, value);
          cell.high = std::max(cell.high, value);
          cell.sum += value;
          ++cell.count;
        }
      }
    }
    return cell;
  }

  /// The value where there are no data is none.
  double number(double value) const { return value == fill_ ? none : value; }

  /// If a tap is not a number, the cell's mean is used instead.
  template <class T>
  T limited(double filtered, const Cell& cell) const {
    if (cell.count == 0) return static_cast<T>(fill_);
    const double value =
        std::isfinite(filtered) ? std::clamp(filtered, cell.low, cell.high) : cell.sum / cell.count;
    return static_cast<T>(std::is_floating_point_v<T> ? value : std::round(value));
  }

  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const double fill_ = notes().fill.value_or(none);
  std::map<int, std::vector<std::byte>> kept_;  ///< slices of the full volume
};

}  // namespace

Grid reduced_grid(const Grid& grid, const Reduction& reduction) {
  if (reduction.factor < 1)
    throw InputError(fmt::format("--undersample {} is no number of voxels", reduction.factor),
                     "use 1, 2 or 4");
  Grid reduced = grid;
  reduced.dims = (grid.dims + (reduction.factor - 1)) / reduction.factor;
  reduced.spacing = grid.spacing * double(reduction.factor);
  if (reduction.prefilter) reduced.origin += grid.direction * (grid.spacing * (0.5 * (reduction.factor - 1)));
  return reduced;
}

int reduced_layer_depth(int depth, const Reduction& reduction) {
  return std::max(1, depth / reduction.factor);
}

VoxelBox reduced_box(const VoxelBox& box, const Grid& grid, const Reduction& reduction) {
  const glm::ivec3 dims = reduced_grid(grid, reduction).dims;
  const int factor = reduction.factor;
  // Voxel i lies at factor * i + shift / 2. The box ends half a voxel before `first` and `end`.
  const int shift = reduction.prefilter ? factor - 1 : 0;
  const auto first_behind = [&](std::int64_t face) {
    const std::int64_t twice = 2 * face - 1 - shift, step = 2 * std::int64_t(factor);
    return twice <= 0 ? 0 : static_cast<int>((twice + step - 1) / step);
  };
  VoxelBox reduced;
  for (int k = 0; k < 3; ++k) {
    int first = box.first[k] == 0 ? 0 : first_behind(box.first[k]),
        end = box.end[k] == grid.dims[k] ? dims[k] : std::min(first_behind(box.end[k]), dims[k]);
    if (first >= end) {
      const std::int64_t twice_middle = std::int64_t(box.first[k]) + box.end[k] - 1 - shift;
      first = static_cast<int>(
          std::clamp<std::int64_t>((twice_middle + factor) / (2 * std::int64_t(factor)), 0, dims[k] - 1));
      end = first + 1;
    }
    reduced.first[k] = first;
    reduced.end[k] = end;
  }
  return reduced;
}

std::unique_ptr<VolumeSource> reduced_source(VolumeSource& full, const Reduction& reduction) {
  if (!reduction.prefilter)
    return skipping_source(std::make_unique<ForwardingSource>(full), reduced_grid(full.grid(), reduction),
                           reduction.factor);
  if (reduction.factor != 2 && reduction.factor != 4)
    throw InputError(fmt::format("--undersample {} has no prefilter", reduction.factor), "use 2 or 4");
  const Reduction halving{2, true};
  auto half = std::make_unique<HalvedSource>(full, reduced_grid(full.grid(), halving));
  if (reduction.factor == 2) return half;
  const Grid quarter = reduced_grid(half->grid(), halving);
  return std::make_unique<HalvedSource>(std::move(half), quarter);
}

}  // namespace ringsplat
