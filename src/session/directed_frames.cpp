#include "session/directed_frames.hpp"

#include <utility>

#include "frame/frame_geometry.hpp"
#include "frame/frame_spec_bytes.hpp"

namespace ringsplat {

DirectedFrames::DirectedFrames(Director director, const Grid& grid, int renderers)
    : director_(std::move(director)), grid_(grid), renderers_(renderers) {}

std::optional<Bytes> DirectedFrames::next(std::int64_t frame) {
  auto spec = director_.next_frame();
  if (!spec) return std::nullopt;
  spec->frame = frame;
  if (spec->division.dealt_to == 0) spec->division.dealt_to = renderers_;
  Bytes body = encode(*spec);
  frames_[frame].spec = std::move(*spec);
  return body;
}

bool DirectedFrames::unwanted(std::int64_t frame) {
  return director_.unwanted && director_.unwanted(frames_.at(frame).spec);
}

void DirectedFrames::done(FrameStats&& stats) {
  auto [spec, image] = std::move(frames_.extract(stats.frame).mapped());
  if (stats.dropped) return;
  const Axis axis = traversed_axis(spec, grid_);
  director_.frame_done({std::move(spec), std::move(image), std::move(stats), axis});
}

void DirectedFrames::pause(std::chrono::nanoseconds most) {
  if (director_.pause)
    director_.pause(most);
  else
    FrameSource::pause(most);
}

}  // namespace ringsplat
