#include "volume/masked.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <limits>
#include <type_traits>

#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"
#include "volume/scalars.hpp"

namespace ringsplat {
namespace {

/// Places in one grid as places in another.
struct LatticeMap {
  glm::dmat3 turn;
  glm::dvec3 shift;

  LatticeMap(const Grid& from, const Grid& to) {
    const auto lattice = [](const Grid& g) {
      return glm::dmat3(g.direction[0] * g.spacing.x, g.direction[1] * g.spacing.y,
                        g.direction[2] * g.spacing.z);
    };
    const glm::dmat3 back = glm::inverse(lattice(to));
    turn = back * lattice(from);
    shift = back * (from.origin - to.origin);
  }
  /// Rounded down it is the nearest voxel, of two the one with the greater number, however places are
  /// rounded.
  glm::dvec3 nearest(const glm::dvec3& place) const {
    constexpr double rounding = 1e-9;
    return turn * place + shift + (0.5 + rounding);
  }
};

/// Of voxels without data, as a number of the grid's type.
double outside_value(const VolumeNotes& notes, ScalarType type) {
  if (notes.fill) return *notes.fill;
  constexpr double nothing = std::numeric_limits<double>::quiet_NaN(), air = -1000;
  return visit_type(type, [&](auto zero) {
    using T = decltype(zero);
    if (std::is_floating_point_v<T>) return nothing;
    return notes.modality == "CT" && double(std::numeric_limits<T>::lowest()) < air ? air : 0.0;
  });
}

class MaskedSource final : public ForwardingSource {
 public:
  MaskedSource(std::unique_ptr<VolumeSource> volume, std::unique_ptr<VolumeSource> segmentation,
               LabelRanges labels, bool same_grid)
      : ForwardingSource(std::move(volume)),
        segmentation_(std::move(segmentation)),
        labels_(std::move(labels)),
        map_(grid(), same_grid ? grid() : segmentation_->grid()),
        outside_(outside_value(source_.notes(), grid().type)) {}

  bool concurrent() const override { return source_.concurrent() && segmentation_->concurrent(); }
  Facts facts() const override {
    Facts facts = source_.facts();
    for (Fact fact : segmentation_->facts())
      facts.push_back({"segmentation's " + std::move(fact.field), std::move(fact.value)});
    std::string shown;
    for (const auto& [first, last] : labels_) shown += fmt::format(" {} to {}", first, last);
    facts.push_back({"labels", shown});
    return facts;
  }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    source_.read_slices(first, count, out);
    const std::size_t bytes = grid().slice_bytes(Axis::z);
    for (int k = 0; k < count; ++k) mask(first + k, out.subspan(std::size_t(k) * bytes, bytes));
  }

 private:
  void mask(int z, std::span<std::byte> slice) {
    const glm::ivec3 dims = segmentation_->grid().dims;
    read_labels(z);
    visit_type(grid().type, [&](auto zero) {
      using T = decltype(zero);
      const T outside = static_cast<T>(outside_);
      std::byte* to = slice.data();
      for (int y = 0; y < grid().dims.y; ++y)
        for (int x = 0; x < grid().dims.x; ++x, to += sizeof(T)) {
          const glm::dvec3 nearest = map_.nearest({x, y, z});
          const bool inside = glm::all(glm::lessThanEqual(glm::dvec3(0), nearest)) &&
                              glm::all(glm::lessThan(nearest, glm::dvec3(dims)));
          const glm::ivec3 at = inside ? glm::ivec3(nearest) : glm::ivec3(0);
          if (!inside || !shown_[(std::size_t(at.z - first_) * dims.y + at.y) * dims.x + at.x])
            std::memcpy(to, &outside, sizeof(T));
        }
    });
  }

  /// Sets shown_ for all slices of the segmentation that slice z of the volume meets.
  void read_labels(int z) {
    const Grid& there = segmentation_->grid();
    const glm::ivec3 last = grid().dims - 1;
    double least = there.dims.z, greatest = -1;
    for (const int x : {0, last.x})
      for (const int y : {0, last.y}) {
        const double at = map_.nearest({x, y, z}).z;
        least = std::min(least, at);
        greatest = std::max(greatest, at);
      }
    const int low = int(std::max(least, 0.0)), high = int(std::floor(std::min(greatest, there.dims.z - 1.0)));
    if (low > high || (low >= first_ && high <= last_)) return;
    first_ = low;
    last_ = high;
    std::vector<std::byte> values(std::size_t(high - low + 1) * there.slice_bytes(Axis::z));
    segmentation_->read_slices(low, high - low + 1, values);
    for_values(there.type, values, [&](const auto& labels) {
      shown_.resize(labels.size());
      std::ranges::transform(labels, shown_.begin(), [&](auto label) { return is_shown(double(label)); });
    });
  }

  bool is_shown(double label) const {
    if (labels_.empty()) return label != 0 && is_finite(label);
    return std::ranges::any_of(
        labels_, [label](const auto& l) { return double(l.first) <= label && label <= double(l.second); });
  }

  std::unique_ptr<VolumeSource> segmentation_;
  LabelRanges labels_;
  LatticeMap map_;
  double outside_;
  std::vector<char> shown_;  ///< of the segmentation's slices first_ to last_
  int first_ = 0, last_ = -1;
};

}  // namespace

std::unique_ptr<VolumeSource> masked_source(std::unique_ptr<VolumeSource> volume,
                                            std::unique_ptr<VolumeSource> segmentation, LabelRanges labels) {
  const World world = volume->notes().world;
  const bool same_world = world == segmentation->notes().world,
             same_size = volume->grid().dims == segmentation->grid().dims;
  if (!same_world && !same_size)
    throw InputError(
        "the segmentation's world coordinates are not of the volume's kind",
        "give one that is as many voxels along x, y and z, or has an orientation as the volume has");
  // The lattice's own coordinates say nothing of where a grid lies.
  const bool same_grid = same_size && (!same_world || world == World::lattice);
  return std::make_unique<MaskedSource>(std::move(volume), std::move(segmentation), std::move(labels),
                                        same_grid);
}

}  // namespace ringsplat
