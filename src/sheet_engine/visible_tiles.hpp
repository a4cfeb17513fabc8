#pragma once
#include <cstddef>
#include <vector>

#include "screen/regions.hpp"
#include "sheet_engine/paint_group.hpp"

namespace ringsplat {

/// The groups of pixels of some regions, and which of their tiles each pending slab may show.
class VisibleTiles {
 public:
  /// A group of pixels in one of the regions.
  struct Group {
    std::size_t slot;  ///< the region's place among them
    int column, row;   ///< in groups, within the region
  };

  /// Lays out the groups of `some` of the regions.
  void lay_out(const Regions& all, const std::vector<int>& some);
  /// Forgets all slabs.
  void clear() { masks_.clear(); }
  /// Adds a slab; mark() then marks its tiles.
  void add_slab() { masks_.resize(masks_.size() + groups_.size(), 0); }
  /// Takes back the last slab.
  void drop_slab() { masks_.resize(masks_.size() - groups_.size()); }
  /// Forgets the first slabs.
  void drop_first(std::size_t slabs) {
    masks_.erase(masks_.begin(), masks_.begin() + std::ptrdiff_t(slabs * groups_.size()));
  }
  /// Marks the tiles of the last slab that pixels of the image plane touch; false when there are none.
  bool mark(const PixelWindow& pixels);
  /// How many tiles of the last slab are marked.
  std::size_t marked() const;

  const std::vector<Group>& groups() const { return groups_; }
  /// By slab, from the first pending one: masks_of(g)[slab * stride()].
  const TileMask* masks_of(std::size_t group) const { return masks_.data() + group; }
  std::ptrdiff_t stride() const { return std::ptrdiff_t(groups_.size()); }

 private:
  struct Region {
    PixelRect rect;
    std::size_t first_group = 0;
    int columns = 0;  ///< of groups
  };
  static void mark_region(const Region& region, const PixelWindow& pixels, TileMask* masks);

  Regions all_;
  std::vector<Region> regions_;  ///< of all; those that are not laid out have no columns
  std::vector<Group> groups_;
  std::vector<TileMask> masks_;  ///< [slab][group]
};

}  // namespace ringsplat
