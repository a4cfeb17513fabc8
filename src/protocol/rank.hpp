#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/log.hpp"
#include "net/loopback.hpp"
#include "net/mesh_transport.hpp"
#include "net/message.hpp"
#include "net/transport.hpp"
#include "protocol/frame_source.hpp"
#include "protocol/node.hpp"
#include "protocol/protocol_options.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

/// A mesh's frames on rank 0: a complete frame is handed on once what all links carried for it is known.
class CountedFrames final : public FrameSource {
 public:
  /// Both must outlive it.
  CountedFrames(FrameSource& frames, MeshTransport& mesh, int frames_in_flight)
      : frames_(frames), mesh_(mesh), most_(frames_in_flight) {}

  std::optional<Bytes> next(std::int64_t frame) override {
    // One frame more than may be under way may be counted, so that this does not delay the next frame.
    if (ended_ || under_way_ + int(counting_.size()) > most_) return std::nullopt;
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
  FrameSource& frames_;
  MeshTransport& mesh_;
  int most_;
  int under_way_ = 0;  ///< announced and not complete
  std::deque<FrameStats> counting_;
  bool ended_ = false;
};

/// One rank: its nodes, what carries their messages in a layout, and the progress loop that gives them
/// messages and time. What comes is taken between the nodes' bounded pieces of work.
class Host {
 public:
  /// All that is passed by reference or pointer must outlive it. `source` is needed on rank 0 only.
  Host(const Layout& layout, const ProtocolOptions& options, Transport& network, Engine& engine,
       FrameSource* source, const Between& between = {})
      : layout_(layout), options_(options), transport_(&network), source_(source) {
    if (layout.routed())
      transport_ = &mesh_.emplace(layout, options.link_slots, network, between.on_link_use);
    if (mesh_ && source != nullptr) source_ = &counted_.emplace(*source, *mesh_, options.frames_in_flight);
    if (between.pace) paced_ = between.pace(*transport_);
    if (paced_) transport_ = paced_.get();
    if (layout.idle > 0) transport_->only_first_work(layout.working_ranks());
    const Post send = [this](Message m) { post(std::move(m)); },
               to_all = [this](Message m) { announce(std::move(m)); };
    for (const NodeId node : layout.nodes_on(rank())) {
      const auto make = node.role == Role::gp ? make_gp : make_renderer;
      nodes_.push_back(node == frame_buffer_id
                           ? make_frame_buffer({0, layout, options, engine, to_all}, *source_)
                           : make({node.index, layout, options, engine, send}));
    }
  }

  /// Handles the messages that have arrived and lets every node work a little; false when nothing could be
  /// done.
  bool step() {
    bool moved = transport_->begin_turn();
    // Messages first: tokens, accepts and messages in transit unblock other ranks.
    moved = take_arrived() || moved;
    for (const auto& node : nodes_) {
      moved = node->advance() || moved;
      // Finish the slice while its data is in the cache.
      while (node->amid_slice() && node->advance()) take_arrived();
    }
    return moved;
  }

  /// True once the run is shut down and everything is sent.
  bool finished() { return shutting_down_ && local_.empty() && transport_->sends_done(); }
  /// Steps until finished; throws RunError when nothing moved for the stall timeout.
  void run() {
    constexpr double longest_between_steps = 0.1;
    double still = 0, last = now_seconds();
    while (!finished()) {
      const bool moved = step();
      const double passed = seconds_awake(last, longest_between_steps);
      if (moved) {
        transport_->note_progress();
        still = 0;
      } else {
        still += passed;
        const bool overdue = still > options_.stall_timeout;
        // Between frames a wait of any length is normal: nobody may ask for a view.
        if (overdue && waiting_for().empty()) {
          still = 0;
        } else if (overdue && (options_.stall_ends || !told_stall_)) {
          report_stall();
          if (options_.stall_ends)
            throw RunError(fmt::format("nothing moved for {} s: {}", options_.stall_timeout, waiting_for()),
                           "a rank may have died or be very slow; --stall-timeout sets the limit");
        }
        wait();
      }
    }
  }

  /// What this rank's nodes wait for, in words; empty when they are done or wait for the next frame.
  std::string waiting_for() const {
    std::vector<std::string> all;
    for (const auto& node : nodes_) all.push_back(node->waiting_for());
    all.push_back(transport_->waiting_for());
    std::erase(all, "");
    return fmt::to_string(fmt::join(all, "; "));
  }

  int rank() const { return transport_->rank(); }

 private:
  void post(Message message) {
    const int to = layout_.rank_of(message.header.to());
    if (to == rank())
      local_.push_back(std::move(message));
    else
      transport_->send(to, std::move(message));
  }

  void wait() {
    if (!early_frames_.empty() ||
        !std::ranges::all_of(nodes_, [](const auto& node) { return node->idle(); })) {
      transport_->wait_next();
    } else if (source_ != nullptr && rank() == 0) {
      transport_->wait_between_frames([this](std::chrono::nanoseconds most) { source_->pause(most); });
    } else {
      transport_->wait_between_frames({});
    }
  }

  std::optional<Message> next_arrived() {
    if (local_.empty()) return transport_->receive();
    Message message = std::move(local_.front());
    local_.pop_front();
    return message;
  }

  bool take_arrived() {
    bool moved = false;
    while (auto message = next_arrived()) {
      check(message->header, layout_);
      take(std::move(*message));
      moved = true;
    }
    return transport_->relayed() || moved;
  }

  void announce(Message message) {
    // Idle ranks receive only the shutdown.
    const int ranks = message.header.kind == Kind::shutdown ? layout_.ranks() : layout_.working_ranks();
    for (const int child : announcement_children(rank(), ranks)) {
      Message copy = message;
      copy.header.destination_role = Role::host;
      copy.header.destination = child;
      transport_->send(child, std::move(copy));
    }
    take_announcement(message);
  }

  void take(Message message) {
    const Header& h = message.header;
    if (h.kind == Kind::announcement || h.kind == Kind::drop || h.kind == Kind::shutdown)
      return announce(std::move(message));
    if (h.kind == Kind::stall) return report_stall();
    const auto node = std::ranges::find(nodes_, h.to(), [](const auto& one) { return one->id(); });
    if (node == nodes_.end())
      throw RunError(fmt::format("rank {} got a {} for {}, which it does not host", rank(), name(h.kind),
                                 to_string(h.to())));
    // The network does not keep an order; only the frame buffer knows a frame before its announcement is
    // here.
    if (h.frame >= next_frame_ && h.to() != frame_buffer_id)
      early_messages_.push_back(std::move(message));
    else
      (*node)->receive(std::move(message));
  }

  void take_announcement(const Message& message) {
    if (message.header.kind == Kind::shutdown) {
      shutting_down_ = true;
      return;
    }
    if (message.header.kind == Kind::drop) {
      early_drops_.insert(message.header.frame);
      drop_announced();
      return;
    }
    const std::int64_t frame = message.header.frame;
    told_stall_ = false;
    early_frames_.emplace(frame, Announcement{frame, Bytes(message.body().begin(), message.body().end())});
    // Announcements may overtake each other; nodes get frames in order.
    for (auto next = early_frames_.begin(); next != early_frames_.end() && next->first == next_frame_;
         next = early_frames_.erase(next), ++next_frame_)
      for (const auto& node : nodes_) node->begin_frame(next->second);
    for (Message& early : std::exchange(early_messages_, {})) take(std::move(early));
    drop_announced();
  }

  void drop_announced() {
    while (!early_drops_.empty() && *early_drops_.begin() < next_frame_) {
      for (const auto& node : nodes_) node->drop_frame(*early_drops_.begin());
      early_drops_.erase(early_drops_.begin());
    }
  }

  /// Prints once what this rank waits for, and asks all others to do the same.
  void report_stall() {
    if (told_stall_) return;
    told_stall_ = true;
    const std::string what = waiting_for();
    log_error("rank {} is stalled: {}", rank(), what.empty() ? "it waits for the next frame" : what);
    for (int r = 0; r < layout_.ranks(); ++r)
      if (r != rank())
        transport_->send(r, Message({.kind = Kind::stall, .source = rank(), .destination = r}));
    // Time for the request to arrive and the answers to be printed before the run ends.
    const double until = now_seconds() + 0.5;
    while (now_seconds() < until) {
      static_cast<void>(transport_->sends_done());
      transport_->wait_next();
    }
  }

  Layout layout_;
  ProtocolOptions options_;
  std::optional<MeshTransport> mesh_;
  std::optional<CountedFrames> counted_;  ///< a mesh's frames
  std::unique_ptr<Transport> paced_;
  Transport* transport_;  ///< the one of these that nodes see, or the network
  FrameSource* source_;
  std::vector<std::unique_ptr<Node>> nodes_;
  std::deque<Message> local_;  ///< messages between nodes of this rank
  std::map<std::int64_t, Announcement> early_frames_;
  std::vector<Message> early_messages_;  ///< of frames not yet announced here
  std::set<std::int64_t> early_drops_;   ///< drops of frames not yet announced here
  std::int64_t next_frame_ = 0;
  bool shutting_down_ = false;
  bool told_stall_ = false;
};

/// Runs all ranks of a layout in this thread until the source has no more frames. `make_engine(rank)` makes
/// each rank's engine. With `loopback.reorder` the ranks' turns are shuffled too. Throws RunError that says
/// who waits for whom when no rank can move and no message on its way can change that.
inline void run_loopback(const Layout& layout, const ProtocolOptions& options,
                         const std::function<std::unique_ptr<Engine>(int rank)>& make_engine,
                         FrameSource& source, const LoopbackOptions& loopback = {}) {
  LoopbackNetwork network(layout.ranks(), loopback);
  std::vector<std::unique_ptr<Engine>> engines;
  std::vector<std::unique_ptr<Host>> ranks;
  for (int rank = 0; rank < layout.ranks(); ++rank) {
    engines.push_back(make_engine(rank));
    ranks.push_back(std::make_unique<Host>(layout, options, network.transport(rank), *engines.back(),
                                           rank == 0 ? &source : nullptr, loopback.between));
  }
  std::vector<std::size_t> order(ranks.size());
  std::iota(order.begin(), order.end(), 0);
  int quiet_turns = 0, pauses = 0;
  while (!std::ranges::all_of(ranks, [](const auto& r) { return r->finished(); })) {
    if (loopback.poll) loopback.poll();
    // Asked before the ranks are: another thread may end the source while they look for its next frame.
    const bool more_may_come = source.may_come();
    if (loopback.reorder)
      for (std::size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[network.random_below(k)]);
    bool moved = false;
    for (const auto rank : order) moved = ranks[rank]->step() || moved;
    network.turn();
    quiet_turns = moved ? 0 : quiet_turns + 1;
    if (moved) pauses = 0;
    // A delayed message arrives within max_delay turns.
    if (quiet_turns <= loopback.max_delay && (moved || network.in_flight())) continue;
    if (loopback.at_standstill && loopback.at_standstill()) {
      quiet_turns = 0;
      continue;
    }
    if (more_may_come) {
      constexpr auto shortest = std::chrono::microseconds(200), longest = std::chrono::microseconds(10000);
      source.pause(std::min(longest, shortest * (1 + pauses++ / 16)));
      continue;
    }
    std::string who;
    for (const auto& rank : ranks) {
      const std::string what = rank->waiting_for();
      who += fmt::format("\n  rank {}: {}", rank->rank(), what.empty() ? "the next frame" : what);
    }
    throw RunError("no rank can move and no message on its way can change that:" + who);
  }
}

}  // namespace ringsplat
