#pragma once
#include <chrono>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "record/stats.hpp"
#include "ringsplat/base/image.hpp"
#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat {

struct FrameResult {
  FrameSpec spec;
  Image image;
  FrameStats stats;
  Axis axis = Axis::z;  ///< of the slice set that was traversed
};

/// Supplies frames to render and takes the results; lives on rank 0.
struct Director {
  /// The next frame to render, or nothing when there are no more. `frame` is set by the frame buffer: 0, 1,
  /// 2 …
  std::function<std::optional<FrameSpec>()> next_frame;
  std::function<void(FrameResult&&)> frame_done;
  /// True while next_frame has nothing now and may have something later, as when views arrive during the run.
  /// May be left empty.
  std::function<bool()> may_come = {};
  /// True when an announced frame is no longer wanted: it is dropped and not passed to frame_done.
  std::function<bool(const FrameSpec&)> unwanted = {};
  /// Waits until next_frame may have something, so long at most. May be left empty: it is asked again and
  /// again.
  std::function<void(std::chrono::nanoseconds)> pause = {};
};

/// The frame as each camera sees it.
inline std::vector<FrameSpec> frames_of(const FrameSpec& frame, const std::vector<Camera>& cameras) {
  std::vector<FrameSpec> frames(cameras.size(), frame);
  for (std::size_t k = 0; k < frames.size(); ++k) frames[k].shown.camera = cameras[k];
  return frames;
}

/// Renders `frames`, one after another.
inline Director director_of(std::vector<FrameSpec> frames, std::function<void(FrameResult&&)> frame_done) {
  const auto next = [frames = std::move(frames), asked = std::size_t{0}]() mutable {
    return asked < frames.size() ? std::optional(frames[asked++]) : std::nullopt;
  };
  return {next, std::move(frame_done)};
}

}  // namespace ringsplat
