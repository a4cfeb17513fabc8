#include "session/director.hpp"

#include <utility>

namespace ringsplat {

Director director_of(std::vector<FrameSpec> frames, std::function<void(FrameResult&&)> frame_done) {
  const auto next = [frames = std::move(frames), asked = std::size_t{0}]() mutable {
    return asked < frames.size() ? std::optional(frames[asked++]) : std::nullopt;
  };
  return {next, std::move(frame_done)};
}

}  // namespace ringsplat
