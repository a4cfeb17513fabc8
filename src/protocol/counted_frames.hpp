#pragma once
#include <deque>

#include "net/mesh_transport.hpp"
#include "protocol/frame_source.hpp"

namespace ringsplat {

/// A mesh's frames on rank 0: a complete frame is handed on once what all links carried for it is known.
class CountedFrames final : public FrameSource {
 public:
  /// Both must outlive it.
  CountedFrames(FrameSource& frames, MeshTransport& mesh, int frames_in_flight)
      : frames_(frames), mesh_(mesh), most_(frames_in_flight) {}

  std::optional<Bytes> next(std::int64_t frame) override {
    if (ended_ || waits()) return std::nullopt;
    auto body = frames_.next(frame);
    if (body)
      ++under_way_;
    else
      ended_ = !frames_.may_come();
    return body;
  }
  /// The end is said when all is counted, since no rank answers after it.
  bool may_come() override { return under_way_ > 0 || !counting_.empty() || (!ended_ && frames_.may_come()); }
  bool unwanted(std::int64_t frame) override { return frames_.unwanted(frame); }
  void done(FrameStats&& stats) override {
    --under_way_;
    const std::int64_t frame = stats.frame;
    counting_.push_back(std::move(stats));
    mesh_.collect_counts(frame, [this](std::vector<LinkCounts> counts) {
      FrameStats counted = std::move(counting_.front());
      counting_.pop_front();
      counted.links = std::move(counts);
      frames_.done(std::move(counted));
    });
  }
  void pause(std::chrono::nanoseconds most) override { frames_.pause(most); }

 private:
  /// One frame more than may be under way may be counted, so that this does not delay the next frame.
  bool waits() const { return under_way_ + int(counting_.size()) > most_; }

  FrameSource& frames_;
  MeshTransport& mesh_;
  int most_;
  int under_way_ = 0;  ///< announced and not complete
  std::deque<FrameStats> counting_;
  bool ended_ = false;
};

}  // namespace ringsplat
