#pragma once
#include <functional>
#include <map>
#include <vector>

#include "net/collectives.hpp"
#include "scene/load.hpp"
#include "scene/slice_supply.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

/// What a deal makes of its slices, for whom.
struct Deal {
  const LoadOptions& options;  ///< of a single level
  SliceDealing dealing;
  const std::vector<std::vector<int>>& gps_of_process;
  /// This process's stores of the same volume, whose values are taken over; null: none.
  const std::map<int, SliceStore>* known = nullptr;
  /// Called with the end of the slices that are dealt.
  std::function<void(int end)> dealt = {};
};

/// Gives GPs the slices of the kept axes. Returns this process's stores by GP.
std::map<int, SliceStore> deal_slices(const Grid& grid, SliceSupply& supply, const Deal& deal,
                                      Collectives& collectives);

}  // namespace ringsplat
