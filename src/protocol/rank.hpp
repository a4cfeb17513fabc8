#pragma once
#include <functional>
#include <memory>
#include <optional>

#include "protocol/counted_frames.hpp"
#include "protocol/host.hpp"

namespace ringsplat {

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
