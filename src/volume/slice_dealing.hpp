#pragma once
#include <algorithm>
#include <cstdint>

namespace ringsplat {

/// Who owns which slices of an axis: GPs get them in turn, one at a time (Neumann 1992, section 3: a static,
/// interleaved slab distribution), or `slab` consecutive ones at a time. Slice s is of GP (s / slab) mod gps;
/// the last slab may be shorter.
struct SliceDealing {
  int gps, slab;

  /// A number of GPs alone deals single slices.
  SliceDealing(int gp_count = 1, int slices_of_slab = 1) : gps(gp_count), slab(slices_of_slab) {}

  int slab_of(int slice) const { return slice / slab; }
  int owner_of(int slice) const { return slab_of(slice) % gps; }
  /// How many of an axis's `slices` slices a GP owns. GP 0 has the most.
  int owned_count(int slices, int gp) const {
    const std::int64_t rest = slices % period() - std::int64_t{gp} * slab;
    return int(slices / period() * slab + std::clamp<std::int64_t>(rest, 0, slab));
  }
  /// A slice's place among those of its owner, from 0.
  int place_of(int slice) const { return int(slice / period() * slab) + slice % slab; }
  /// The slice at a place of a GP's; beyond the last there may be none.
  int slice_at(int gp, int place) const {
    return int(place / slab * period() + std::int64_t{gp} * slab + place % slab);
  }

 private:
  /// Slices of which every GP gets a slab.
  std::int64_t period() const { return std::int64_t{gps} * slab; }
};

}  // namespace ringsplat
