#pragma once
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "net/transport.hpp"
#include "protocol/frame_source.hpp"
#include "protocol/node.hpp"
#include "protocol/protocol_options.hpp"

namespace ringsplat {

/// One rank: its nodes, and the progress loop that gives them messages and time. What comes is taken between
/// the nodes' bounded pieces of work.
class Host {
 public:
  /// All that is passed by reference or pointer must outlive it. `source` is needed on rank 0 only.
  Host(const Layout& layout, const ProtocolOptions& options, Transport& transport, Engine& engine,
       FrameSource* source);

  /// Handles the messages that have arrived and lets every node work a little; false when nothing could be
  /// done.
  bool step();
  /// True once the run is shut down and everything is sent.
  bool finished();
  /// Steps until finished; throws RunError when nothing moved for the stall timeout.
  void run();
  /// What this rank's nodes wait for, in words; empty when they are done or wait for the next frame.
  std::string waiting_for() const;
  int rank() const { return transport_.rank(); }

 private:
  void post(Message message);
  void wait();
  bool idle() const;
  bool take_arrived();
  void announce(Message message);
  void take(Message message);
  void take_announcement(const Message& message);
  void drop_announced();
  void report_stall();
  Node* local_node(NodeId id);

  Layout layout_;
  ProtocolOptions options_;
  Transport& transport_;
  FrameSource* source_;
  std::vector<std::unique_ptr<Node>> nodes_;
  std::deque<Message> local_;  ///< messages between nodes of this rank
  std::map<std::int64_t, Announcement> early_frames_;
  std::set<std::int64_t> early_drops_;  ///< drops of frames not yet announced here
  std::int64_t next_frame_ = 0;
  bool shutting_down_ = false;
  bool told_stall_ = false;
};

}  // namespace ringsplat
