#include "engine_parts/checks.hpp"

#include <fmt/format.h>

#include "ringsplat/base/error.hpp"

namespace ringsplat {

void check_loaded(const SliceStore& store, Axis traversed, std::int64_t number) {
  if (!store.keeps(traversed))
    throw RunError(
        fmt::format("frame {} traverses the {} axis, whose slices were not loaded", number, name(traversed)),
        "load it with --axes all");
}

void check_step(int renderer, int step, int slices) {
  if (step < 0 || step >= slices)
    throw RunError(
        fmt::format("Renderer {} got a payload for step {} of a traversal of {}", renderer, step, slices),
        "all ranks must run the same build");
}

}  // namespace ringsplat
