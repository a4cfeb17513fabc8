#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <thread>

#include "record/stats.hpp"
#include "ringsplat/base/bytes.hpp"

namespace ringsplat {

/// Supplies the frame buffer with frames; lives on rank 0.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// Returns the body of frame `frame`'s announcement, or nothing when there is none now.
  virtual std::optional<Bytes> next(std::int64_t frame) = 0;
  /// True while next() has nothing now and may have something later.
  virtual bool may_come() = 0;
  /// True when an announced frame is not wanted any more: it is dropped.
  virtual bool unwanted(std::int64_t frame) = 0;
  /// The frame is over: its canvas was finished, unless the frame was dropped.
  virtual void done(FrameStats&& stats) = 0;
  /// Waits, so long at most, while no frame is under way; returns sooner when next() may have something. A
  /// source that does not know when waits a millisecond at most.
  virtual void pause(std::chrono::nanoseconds most) {
    constexpr std::chrono::nanoseconds unaware{1'000'000};
    std::this_thread::sleep_for(std::min(most, unaware));
  }
};

}  // namespace ringsplat
