#include "engine_parts/announced_frames.hpp"

#include "frame/frame_spec_bytes.hpp"

#include <fmt/format.h>

namespace ringsplat {

FrameSpec announced_spec(const Announcement& a) {
  FrameSpec spec = decode_frame_spec(a.body);
  if (spec.frame != a.frame)
    throw RunError(fmt::format("rank 0 told of frame {} in a message about frame {}", spec.frame, a.frame));
  return spec;
}

}  // namespace ringsplat
