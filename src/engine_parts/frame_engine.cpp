#include "engine_parts/frame_engine.hpp"

#include <fmt/format.h>

#include "frame/frame_spec_bytes.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

EncodeCounts left_out_of(const FrameGeometry& geometry, std::size_t steps) {
  const auto voxels = steps * std::uint64_t(geometry.grid.slice_voxels(geometry.traversal.axis));
  return {.voxels = voxels, .outside = voxels};
}

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

FrameSpec announced_spec(const Announcement& a) {
  FrameSpec spec = decode_frame_spec(a.body);
  if (spec.frame != a.frame)
    throw RunError(fmt::format("rank 0 told of frame {} in a message about frame {}", spec.frame, a.frame));
  return spec;
}

}  // namespace ringsplat
