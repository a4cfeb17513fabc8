#pragma once
#include <algorithm>
#include <cstdint>

namespace ringsplat {

/// Who owns which slices of an axis: GPs get them in turn, one at a time (Neumann 1992, section 3: a static,
/// interleaved bundle distribution), or `bundle` consecutive ones at a time. Slice s is of GP (s / bundle)
/// mod gps; the last bundle may be shorter.
struct SliceDealing {
  int gps, bundle;

  /// A number of GPs alone deals single slices.
  SliceDealing(int gp_count = 1, int slices_of_bundle = 1) : gps(gp_count), bundle(slices_of_bundle) {}

  int bundle_of(int slice) const { return slice / bundle; }
  int owner_of(int slice) const { return bundle_of(slice) % gps; }
  /// How many of an axis's `slices` slices a GP owns. GP 0 has the most.
  int owned_count(int slices, int gp) const {
    const std::int64_t rest = slices % period() - std::int64_t{gp} * bundle;
    return int(slices / period() * bundle + std::clamp<std::int64_t>(rest, 0, bundle));
  }
  /// A slice's place among those of its owner, from 0.
  int place_of(int slice) const { return int(slice / period() * bundle) + slice % bundle; }
  /// The slice at a place of a GP's; beyond the last there may be none.
  int slice_at(int gp, int place) const {
    return int(place / bundle * period() + std::int64_t{gp} * bundle + place % bundle);
  }

 private:
  /// Slices of which every GP gets a bundle.
  std::int64_t period() const { return std::int64_t{gps} * bundle; }
};

}  // namespace ringsplat
