#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "net/mesh.hpp"
#include "net/message.hpp"
#include "net/transport.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

/// True for messages from node to node: token, payload, accept, frame end, tile, report, in the order of
/// Kind. Announcements and shutdown go along their tree; credits, stall reports and link counts go straight
/// to their rank.
inline bool travels_by_mesh(Kind kind) { return kind >= Kind::token && kind <= Kind::report; }

/// One rank's part of the mesh: takes what its nodes send and what its neighbours hand on, and sends it
/// over the next link as soon as there is room at the other end.
///
/// Memory is bounded: behind every link there are `slots` slots for each of its buffer classes, at the rank
/// it leads to. A message in transit keeps its slot until it has left over its next link; then the
/// neighbour is given the slot back (a credit). A message for which no slot is free waits here, in the slot
/// of the link by which it came. What this rank's own nodes send waits here too; the protocol bounds that
/// (one payload a token, the tiles and the report of a frame).
///
/// Why no chain of waiting messages closes (Dally and Seitz 1987): docs/protocol.md, Mesh. One slot a class
/// is enough; more slots let several messages be on a link.
class MeshRouter {
 public:
  /// Called for every message that starts over a link.
  using Observer = std::function<void(const Link&, const Header&)>;

  MeshRouter(const Layout& mesh, int slots, Transport& transport, Observer observer = {})
      : mesh_(mesh), slots_(slots), transport_(transport), observer_(std::move(observer)) {
    for (const Link& link : links_from(mesh_, transport.rank())) {
      out_.push_back({link, neighbour(mesh_, link.from, link.direction).value(), {}, {}, {}});
      out_.back().free_slots.fill(slots);
    }
  }

  /// Starts a message of this rank on its way to another rank.
  void post(Message message) { forward(std::move(message), std::nullopt); }
  /// Takes what came from the transport. Returns the message when it is for this rank; keeps it when it is
  /// in transit. Throws RunError when this rank is not on the message's route or a credit is not owed.
  std::optional<Message> take(Message message) {
    const Header& h = message.header;
    if (h.kind == Kind::credit) {
      take_credit(h);
      return std::nullopt;
    }
    if (!travels_by_mesh(h.kind)) return message;
    const Hop came_by = hop_here(h, false);
    if (mesh_.rank_of(h.to()) == transport_.rank()) {
      free_slot(came_by);
      return message;
    }
    forward(std::move(message), came_by);
    return std::nullopt;
  }

  /// Gives freed slots back to the neighbours. Call after every round of take().
  void return_credits() {
    for (const auto& [to, slots] : std::exchange(owed_credits_, {}))
      transport_.send(to.first, Message(make_header({Role::host, transport_.rank()}, {Role::host, to.first},
                                                    0, CreditFields{.channel = to.second, .slots = slots})));
  }

  /// True when nothing waits here and every slot this rank filled has been given back.
  bool idle() const {
    return owed_credits_.empty() &&
           std::none_of(out_.begin(), out_.end(), [&](const OutLink& out) { return out.in_use(slots_); });
  }

  /// Who waits for whom at this rank's links, in words; empty when nobody does.
  std::string waiting_for() const {
    std::vector<std::string> all;
    for (const auto& out : out_)
      for (std::size_t c = 0; c < out.waiting.size(); ++c) {
        const int taken = slots_ - out.free_slots[c];
        if (!out.waiting[c].empty())
          all.push_back(fmt::format(
              "{} message(s) wait at link {} for rank {} to free one of {} slot(s), the first is {}",
              out.waiting[c].size(), name(mesh_, out.link), out.to, slots_,
              describe(out.waiting[c].front().message.header)));
        else if (taken > 0)
          all.push_back(fmt::format("rank {} has not yet handed on {} message(s) from link {}", out.to, taken,
                                    name(mesh_, out.link)));
      }
    return fmt::to_string(fmt::join(all, "; "));
  }

  /// Returns what this rank's links carried for a frame, by link, and forgets it.
  std::vector<LinkCounts> take_counts(std::int64_t frame) {
    std::vector<LinkCounts> counts;
    for (OutLink& out : out_) {
      counts.push_back(out.counts[frame]);
      counts.back().link = out.link;
      out.counts.erase(frame);
    }
    return counts;
  }

 private:
  struct Waiting {
    Message message;
    std::optional<Hop> came_by;  ///< none: a message of this rank's own
    double since = 0;            ///< seconds; 0 when it did not wait
  };
  struct OutLink {
    Link link;
    int to;
    std::array<int, buffer_classes> free_slots;
    std::array<std::deque<Waiting>, buffer_classes> waiting;
    std::map<std::int64_t, LinkCounts> counts;  ///< by frame
    bool in_use(int slots) const {
      for (std::size_t c = 0; c < free_slots.size(); ++c)
        if (free_slots[c] < slots || !waiting[c].empty()) return true;
      return false;
    }
  };

  /// Names a (direction, buffer class) of the rank that a credit goes to.
  static std::uint32_t channel(Direction direction, int buffer_class) {
    return static_cast<std::uint32_t>(direction) * buffer_classes + static_cast<std::uint32_t>(buffer_class);
  }

  static std::string describe(const Header& h) {
    const auto place = token_place(h);
    return fmt::format("a {} from {} to {} (frame {}{})", name(h.kind), to_string(h.from()),
                       to_string(h.to()), h.frame,
                       place ? fmt::format(", step {}", place->step) : std::string());
  }

  /// The hop of a message's route by which it comes to this rank, or leaves it.
  Hop hop_here(const Header& h, bool leaves) const {
    for (const Hop& hop : route(mesh_, h.from(), h.to()))
      if ((leaves ? hop.link.from : hop.to) == transport_.rank()) return hop;
    throw RunError(fmt::format("rank {} {} {}, which does not pass here", transport_.rank(),
                               leaves ? "cannot hand on" : "got", describe(h)));
  }

  void forward(Message message, std::optional<Hop> came_by) {
    const Header& h = message.header;
    const Hop hop = hop_here(h, true);
    OutLink& out = *std::ranges::find(out_, hop.link, &OutLink::link);
    const auto buffer_class = static_cast<std::size_t>(hop.buffer_class);
    LinkCounts& counts = out.counts[h.frame];
    ++counts.messages;
    counts.bytes += sizeof(Header) + h.bytes;
    if (h.kind == Kind::payload) {
      ++counts.payloads;
      counts.payload_bytes += sizeof(Header) + h.bytes;
    }
    if (out.in_use(slots_)) ++counts.shared;
    if (out.free_slots[buffer_class] > 0) {
      send(out, hop.buffer_class, {std::move(message), came_by});
      return;
    }
    ++counts.waited;
    out.waiting[buffer_class].push_back({std::move(message), came_by, now_seconds()});
  }

  void send(OutLink& out, int buffer_class, Waiting waiting) {
    --out.free_slots[static_cast<std::size_t>(buffer_class)];
    if (waiting.since > 0)
      out.counts[waiting.message.header.frame].wait_seconds += now_seconds() - waiting.since;
    if (observer_) observer_(out.link, waiting.message.header);
    transport_.send(out.to, std::move(waiting.message));
    if (waiting.came_by) free_slot(*waiting.came_by);
  }

  void free_slot(const Hop& came_by) {
    ++owed_credits_[{came_by.link.from, channel(came_by.link.direction, came_by.buffer_class)}];
  }

  void take_credit(const Header& h) {
    const auto [channel, slots] = fields_of<CreditFields>(h);
    const auto direction = channel / buffer_classes, buffer_class = channel % buffer_classes;
    const auto found = std::find_if(out_.begin(), out_.end(), [&](const OutLink& out) {
      return out.to == h.source && static_cast<std::uint32_t>(out.link.direction) == direction;
    });
    if (found == out_.end() || slots == 0 || slots > std::uint32_t(slots_ - found->free_slots[buffer_class]))
      throw RunError(fmt::format("rank {} gave rank {} {} slot(s) back that it had not taken", h.source,
                                 transport_.rank(), slots));
    found->free_slots[buffer_class] += static_cast<int>(slots);
    auto& waiting = found->waiting[buffer_class];
    while (!waiting.empty() && found->free_slots[buffer_class] > 0) {
      Waiting first = std::move(waiting.front());
      waiting.pop_front();
      send(*found, static_cast<int>(buffer_class), std::move(first));
    }
  }

  const Layout mesh_;
  const int slots_;
  Transport& transport_;
  Observer observer_;
  std::vector<OutLink> out_;
  std::map<std::pair<int, std::uint32_t>, std::uint32_t> owed_credits_;  ///< (neighbour, channel) → slots
};

/// A mesh with manhattan routing: what nodes send each other goes from neighbour to neighbour (MeshRouter),
/// other messages go straight to their rank. Each rank counts what its links carry; rank 0 asks all of them
/// for a frame's counts once the frame is complete, as by then all of it has arrived.
class MeshTransport final : public TransportDecorator {
 public:
  /// `network` must outlive it.
  MeshTransport(const Layout& mesh, int slots, Transport& network, MeshRouter::Observer observer = {})
      : TransportDecorator(network), mesh_(mesh), router_(mesh, slots, network, std::move(observer)) {}

  /// On rank 0: asks for the counts of a frame and passes them on, in the order of ranks. Frames are passed
  /// on in the order in which they are asked for.
  using TakeCounts = std::function<void(std::vector<LinkCounts> counts)>;
  void collect_counts(std::int64_t frame, TakeCounts take) {
    collected_.push_back({frame, std::move(take), {}});
    pass_on_query(Message(make_header(Kind::link_query, {Role::host, rank()}, {Role::host, rank()}, frame)));
  }

  void send(int destination, Message message) override {
    if (travels_by_mesh(message.header.kind))
      router_.post(std::move(message));
    else
      inner_.send(destination, std::move(message));
  }

  std::optional<Message> receive() override {
    while (auto message = inner_.receive()) {
      check(message->header, mesh_);
      message = router_.take(std::move(*message));
      if (message && message->header.kind == Kind::link_query)
        pass_on_query(*message);
      else if (message && message->header.kind == Kind::link_report)
        take_report(*message);
      else if (message)
        return message;
      relayed_ = true;
    }
    router_.return_credits();
    return std::nullopt;
  }

  /// Neighbours may still owe credits, and must receive them, so that none stays in the network.
  bool sends_done() override { return router_.idle() && inner_.sends_done(); }
  bool relayed() override { return std::exchange(relayed_, false); }

  std::string waiting_for() const override {
    std::string all = router_.waiting_for();
    if (!collected_.empty())
      all +=
          fmt::format("{}{} rank(s) have not yet reported their links for frame {}", all.empty() ? "" : "; ",
                      mesh_.ranks() - int(collected_.front().counts.size()), collected_.front().frame);
    return all;
  }

  void wait_between_frames(const Sleep& sleep) override {
    if (collected_.empty())
      inner_.wait_between_frames(sleep);
    else
      inner_.wait_next();
  }

 private:
  /// Counts of a frame that have been asked for.
  struct Collected {
    std::int64_t frame;
    TakeCounts take;
    std::map<int, std::vector<LinkCounts>> counts;  ///< by rank that has reported
  };

  [[noreturn]] static void refuse(NodeId from, std::int64_t frame) {
    throw RunError(
        fmt::format("{} reported its links for frame {} without being asked", to_string(from), frame));
  }

  /// Queries and reports bypass the mesh: they would count themselves.
  void pass_on_query(const Message& query) {
    for (const int child : announcement_children(rank(), mesh_.ranks())) {
      Message copy = query;
      copy.header.destination = child;
      inner_.send(child, std::move(copy));
    }
    const std::int64_t frame = query.header.frame;
    std::vector<LinkCounts> counts = router_.take_counts(frame);
    if (rank() == 0)
      report(frame, 0, std::move(counts));
    else
      inner_.send(0, Message(make_header(Kind::link_report, {Role::host, rank()}, {Role::host, 0}, frame),
                             encode(counts)));
  }

  void report(std::int64_t frame, int rank, std::vector<LinkCounts> counts) {
    const auto asked = std::ranges::find_if(collected_, [&](const Collected& c) { return c.frame == frame; });
    if (asked == collected_.end() || !asked->counts.emplace(rank, std::move(counts)).second)
      refuse({Role::host, rank}, frame);
    while (!collected_.empty() && int(collected_.front().counts.size()) == mesh_.ranks()) {
      const Collected known = std::move(collected_.front());
      collected_.pop_front();
      std::vector<LinkCounts> all;
      for (const auto& [of, its] : known.counts) all.insert(all.end(), its.begin(), its.end());
      known.take(std::move(all));
    }
  }

  void take_report(const Message& message) {
    const Header& h = message.header;
    if (h.source_role != Role::host) refuse(h.from(), h.frame);
    report(h.frame, h.source, decode_link_counts(message.body(), mesh_, h.source));
  }

  Layout mesh_;
  MeshRouter router_;
  std::deque<Collected> collected_;
  bool relayed_ = false;
};

}  // namespace ringsplat
