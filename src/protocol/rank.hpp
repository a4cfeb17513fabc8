#pragma once
#include <deque>
#include <functional>
#include <memory>
#include <optional>

#include "net/mesh_transport.hpp"
#include "protocol/frame_source.hpp"
#include "protocol/host.hpp"

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

/// What a study of a run puts between a rank's nodes and the network.
struct Between {
  /// Stands between links and nodes; empty: nothing does.
  std::function<std::unique_ptr<Transport>(Transport& links)> pace = {};
  MeshRouter::Observer observer = {};  ///< of a mesh's links
};

/// A host with what carries its messages in a layout: a network, and in a mesh its links.
class Rank {
 public:
  /// As Host's.
  Rank(const Layout& layout, const ProtocolOptions& options, Transport& network, Engine& engine,
       FrameSource* source, const Between& between = {}) {
    if (layout.routed()) mesh_.emplace(layout, options.link_slots, network, between.observer);
    if (mesh_ && source != nullptr) source = &frames_.emplace(*source, *mesh_, options.frames_in_flight);
    Transport& links = mesh_ ? *mesh_ : network;
    if (between.pace) paced_ = between.pace(links);
    host_.emplace(layout, options, paced_ ? *paced_ : links, engine, source);
  }
  Host& host() { return *host_; }

 private:
  std::optional<MeshTransport> mesh_;
  std::optional<CountedFrames> frames_;
  std::unique_ptr<Transport> paced_;
  std::optional<Host> host_;
};

}  // namespace ringsplat
