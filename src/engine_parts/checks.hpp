#pragma once
#include <cstdint>

#include "volume/slice_store.hpp"

namespace ringsplat {

/// Throws RunError unless the store has the slices that frame `number` traverses.
void check_loaded(const SliceStore& store, Axis traversed, std::int64_t number);

/// Throws RunError unless a traversal of `slices` slices has the step of a payload that came.
void check_step(int renderer, int step, int slices);

}  // namespace ringsplat
