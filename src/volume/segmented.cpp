#include "volume/segmented.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/matrix.hpp>
#include <iterator>
#include <limits>
#include <map>
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

/// Of voxels without data, as a number of the volume's type. Many files do not say that they are of a CT: its
/// first slice has air.
double outside_value(VolumeSource& volume) {
  const VolumeNotes notes = volume.notes();
  if (notes.fill) return *notes.fill;
  constexpr double nothing = std::numeric_limits<double>::quiet_NaN(), air = -1000;
  std::vector<std::byte> slice(volume.grid().slice_bytes(Axis::z));
  return visit_type(volume.grid().type, [&](auto zero) {
    using T = decltype(zero);
    if (std::is_floating_point_v<T>) return nothing;
    if (double(std::numeric_limits<T>::lowest()) >= air) return 0.0;
    bool is_ct = notes.modality == "CT";
    if (notes.modality.empty()) {
      volume.read_slices(0, 1, slice);
      for_values(volume.grid().type, slice,
                 [&](const auto& values) { is_ct = double(std::ranges::min(values)) < air / 2; });
    }
    return is_ct ? air : 0.0;
  });
}

/// The labels of a volume's voxels, as bytes: 0 where none is shown, else 1 to most_tints, from which on they
/// begin again.
class LabelSource final : public VolumeSource {
 public:
  LabelSource(const Grid& grid, std::unique_ptr<VolumeSource> segmentation, LabelRanges labels,
              bool same_grid, bool outline)
      : grid_(grid),
        segmentation_(std::move(segmentation)),
        labels_(std::move(labels)),
        map_(grid, same_grid ? grid : segmentation_->grid()),
        outline_(outline) {
    grid_.type = ScalarType::uint8;
  }

  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return segmentation_->concurrent(); }
  Facts facts() const override {
    Facts facts;
    for (Fact fact : segmentation_->facts())
      facts.push_back({"segmentation's " + std::move(fact.field), std::move(fact.value)});
    std::string shown;
    for (const auto& [first, last] : labels_) shown += fmt::format(" {} to {}", first, last);
    facts.push_back({"labels", shown});
    return facts;
  }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto voxels = std::ptrdiff_t(grid_.slice_voxels(Axis::z));
    auto* to = reinterpret_cast<std::uint8_t*>(out.data());
    if (!outline_) {
      for (int z = first; z < first + count; ++z, to += voxels) find_labels(z, to);
      return;
    }
    const int low = std::max(first - 1, 0), high = std::min(first + count, grid_.dims.z - 1);
    // The next slices need some of these again, and files are decoded forwards only.
    std::erase_if(found_, [&](const auto& slice) { return slice.first < low || slice.first > high; });
    for (int z = low; z <= high; ++z)
      if (const auto [slice, is_new] = found_.try_emplace(z, std::size_t(voxels)); is_new)
        find_labels(z, slice->second.data());
    for (int z = first; z < first + count; ++z, to += voxels)
      keep_border(found_.at(z).data(), found_.at(std::max(z - 1, low)).data(),
                  found_.at(std::min(z + 1, high)).data(), to);
  }

 private:
  void find_labels(int z, std::uint8_t* to) {
    const glm::ivec3 dims = segmentation_->grid().dims;
    read_labels(z);
    for (int y = 0; y < grid_.dims.y; ++y)
      for (int x = 0; x < grid_.dims.x; ++x, ++to) {
        const glm::dvec3 nearest = map_.nearest({x, y, z});
        const bool inside = glm::all(glm::lessThanEqual(glm::dvec3(0), nearest)) &&
                            glm::all(glm::lessThan(nearest, glm::dvec3(dims)));
        const glm::ivec3 at = inside ? glm::ivec3(nearest) : glm::ivec3(0);
        *to = inside ? read_[(std::size_t(at.z - first_) * dims.y + at.y) * dims.x + at.x] : 0;
      }
  }

  /// Of a slice's labels those with another one beside them, or in the slice before or behind.
  void keep_border(const std::uint8_t* from, const std::uint8_t* before, const std::uint8_t* behind,
                   std::uint8_t* to) const {
    const std::ptrdiff_t row = grid_.dims.x;
    for (int y = 0; y < grid_.dims.y; ++y)
      for (int x = 0; x < grid_.dims.x; ++x, ++from, ++before, ++behind, ++to) {
        const auto differs = [from](bool there, std::ptrdiff_t step) { return there && from[step] != *from; };
        const bool border = differs(x > 0, -1) || differs(x + 1 < grid_.dims.x, 1) || differs(y > 0, -row) ||
                            differs(y + 1 < grid_.dims.y, row) || *before != *from || *behind != *from;
        *to = border ? *from : 0;
      }
  }

  /// Sets read_ for all slices of the segmentation that slice z of the volume meets.
  void read_labels(int z) {
    const Grid& there = segmentation_->grid();
    const glm::ivec3 last = grid_.dims - 1;
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
      read_.resize(labels.size());
      std::ranges::transform(labels, read_.begin(), [&](auto label) { return byte_of(double(label)); });
    });
  }

  std::uint8_t byte_of(double label) const {
    const bool shown = labels_.empty() ? label != 0 && is_finite(label)
                                       : std::ranges::any_of(labels_, [label](const auto& l) {
                                           return double(l.first) <= label && label <= double(l.second);
                                         });
    return shown ? label_byte(label) : 0;
  }

  Grid grid_;
  std::unique_ptr<VolumeSource> segmentation_;
  LabelRanges labels_;
  LatticeMap map_;
  bool outline_;
  std::vector<std::uint8_t> read_;  ///< of the segmentation's slices first_ to last_
  int first_ = 0, last_ = -1;
  std::map<int, std::vector<std::uint8_t>> found_;  ///< labels of the volume's slices that borders need
};

class SegmentedSource final : public ForwardingSource {
 public:
  SegmentedSource(std::unique_ptr<VolumeSource> volume, std::unique_ptr<VolumeSource> labels, bool hides)
      : ForwardingSource(std::move(volume)), labels_(std::move(labels)), hides_(hides) {}

  bool concurrent() const override { return source_.concurrent() && labels_->concurrent(); }
  VolumeSource* labels() override { return hides_ ? nullptr : labels_.get(); }
  Facts facts() const override {
    Facts facts = source_.facts();
    std::ranges::move(labels_->facts(), std::back_inserter(facts));
    return facts;
  }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    source_.read_slices(first, count, out);
    if (!hides_) return;
    if (!outside_) outside_ = outside_value(source_);
    std::vector<std::byte> labels(std::size_t(count) * labels_->grid().slice_bytes(Axis::z));
    labels_->read_slices(first, count, labels);
    visit_type(grid().type, [&](auto zero) {
      using T = decltype(zero);
      const T outside = static_cast<T>(*outside_);
      for (std::size_t i = 0; i < labels.size(); ++i)
        if (labels[i] == std::byte{0}) std::memcpy(out.data() + i * sizeof(T), &outside, sizeof(T));
    });
  }

 private:
  std::unique_ptr<VolumeSource> labels_;
  bool hides_;
  std::optional<double> outside_;  ///< found when voxels are read: many open a volume for its notes
};

}  // namespace

std::uint8_t label_byte(double label) {
  return std::uint8_t(1 + std::fmod(std::max(std::floor(label) - 1, 0.0), most_tints));
}

std::unique_ptr<VolumeSource> segmented_source(std::unique_ptr<VolumeSource> volume,
                                               std::unique_ptr<VolumeSource> segmentation, LabelRanges labels,
                                               Covered covered) {
  const World world = volume->notes().world;
  const bool same_world = world == segmentation->notes().world,
             same_size = volume->grid().dims == segmentation->grid().dims;
  if (!same_world && !same_size)
    throw InputError(
        "the segmentation's world coordinates are not of the volume's kind",
        "give one that is as many voxels along x, y and z, or has an orientation as the volume has");
  // The lattice's own coordinates say nothing of where a grid lies.
  const bool same_grid = same_size && (!same_world || world == World::lattice);
  auto of_voxels = std::make_unique<LabelSource>(volume->grid(), std::move(segmentation), std::move(labels),
                                                 same_grid, covered == Covered::outlined);
  return std::make_unique<SegmentedSource>(std::move(volume), std::move(of_voxels),
                                           covered == Covered::alone);
}

}  // namespace ringsplat
