#pragma once
#include <array>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "net/link_counts.hpp"
#include "net/mesh.hpp"
#include "net/transport.hpp"

namespace ringsplat {

/// True for messages from node to node: token, payload, accept, frame end, tile, report. Announcements and
/// shutdown go along their tree; credits, stall reports and link counts go straight to their rank.
bool travels_by_mesh(Kind kind);

/// One rank's part of the mesh: takes what its nodes send and what its neighbours hand on, and sends it
/// over the next link as soon as there is room at the other end.
///
/// Memory is bounded: behind every link there are `slots` slots for each of its buffer classes, at the rank
/// it leads to. A message in transit keeps its slot until it has left over its next link; then the
/// neighbour is given the slot back (a credit). A message for which no slot is free waits here, in the slot
/// of the link by which it came. What this rank's own nodes send waits here too; the protocol bounds that
/// (one payload a token, the tiles and the report of a frame).
///
/// No deadlock (Dally and Seitz 1987): number the channels (link, buffer class) such that a message only
/// ever waits for a channel with a higher number than the one whose slot it keeps. In this order:
///   1. links out of Renderers: nothing in transit comes through a Renderer, so nothing precedes them;
///   2. vertical links of class 0, southward by row, northward by descending row. A message never changes
///      between south and north;
///   3. vertical links of class 1: the one over the seam first, then as in 2. A message stops before it is
///      round, so it never comes to the seam a second time;
///   4. horizontal links between GPs, westward by descending column, eastward by ascending column;
///   5. links into Renderers.
/// Messages at their destination give their slot back at once, whatever the nodes do: a Renderer keeps at
/// most its slots + 1 payloads of each frame because a token does not move before its payload is accepted,
/// a GP keeps at most its tokens, the frame buffer a frame's tiles. So the message in the highest channel
/// can always move, and no chain of waiting messages closes. One slot a class is enough; more slots let
/// several messages be on a link.
class MeshRouter {
 public:
  /// Called for every message that starts over a link.
  using Observer = std::function<void(const Link&, const Header&)>;

  MeshRouter(const Layout& mesh, int slots, Transport& transport, Observer observer = {});

  /// Starts a message of this rank on its way to another rank.
  void post(Message message);
  /// Takes what came from the transport. Returns the message when it is for this rank; keeps it when it is
  /// in transit. Throws RunError when this rank is not on the message's route or a credit is not owed.
  std::optional<Message> take(Message message);
  /// Gives freed slots back to the neighbours. Call after every round of take().
  void return_credits();

  /// True when nothing waits here and every slot this rank filled has been given back.
  bool idle() const;
  /// Who waits for whom at this rank's links, in words; empty when nobody does.
  std::string waiting_for() const;
  /// Returns what this rank's links carried for a frame, by link, and forgets it.
  std::vector<LinkCounts> take_counts(std::int64_t frame);

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
    bool in_use(int slots) const;
  };

  Hop hop_into_here(const Header& header) const;
  Hop hop_from_here(const Header& header) const;
  OutLink& out_link(Direction direction);
  std::vector<LinkCounts>& counts_of(std::int64_t frame);
  LinkCounts& counts_of(const OutLink& out, std::int64_t frame);
  void forward(Message message, std::optional<Hop> came_by);
  void send(OutLink& out, int buffer_class, Waiting waiting);
  void free_slot(const Hop& came_by);
  void take_credit(const Header& header);

  const Layout mesh_;
  const int slots_;
  Transport& transport_;
  Observer observer_;
  std::vector<OutLink> out_;
  std::map<std::pair<int, std::uint32_t>, std::uint32_t> owed_credits_;  ///< (neighbour, channel) → slots
  std::map<std::int64_t, std::vector<LinkCounts>> counts_;               ///< by frame
};

/// A mesh with manhattan routing: what nodes send each other goes from neighbour to neighbour (MeshRouter),
/// other messages go straight to their rank. Each rank counts what its links carry; rank 0 asks all of them
/// for a frame's counts once the frame is complete, as by then all of it has arrived.
class MeshTransport final : public TransportDecorator {
 public:
  /// `network` must outlive it.
  MeshTransport(const Layout& mesh, int slots, Transport& network, MeshRouter::Observer observer = {});

  /// On rank 0: asks for the counts of a frame and passes them on, in the order of ranks. Frames are passed
  /// on in the order in which they are asked for.
  using TakeCounts = std::function<void(std::vector<LinkCounts> counts)>;
  void collect_counts(std::int64_t frame, TakeCounts take);

  void send(int destination, Message message) override;
  std::optional<Message> receive() override;
  /// Neighbours may still owe credits, and must receive them, so that none stays in the network.
  bool sends_done() override { return router_.idle() && inner_.sends_done(); }
  bool relayed() override { return std::exchange(relayed_, false); }
  std::string waiting_for() const override;
  void wait_between_frames(const Sleep& sleep) override;

 private:
  /// Counts of a frame that have been asked for.
  struct Collected {
    std::int64_t frame;
    TakeCounts take;
    std::map<int, std::vector<LinkCounts>> counts;  ///< by rank that has reported
  };

  void pass_on_query(const Message& query);
  void report(std::int64_t frame, int rank, std::vector<LinkCounts> counts);
  void take_report(const Message& message);

  Layout mesh_;
  MeshRouter router_;
  std::deque<Collected> collected_;
  bool relayed_ = false;
};

}  // namespace ringsplat
