#pragma once
#include <deque>
#include <functional>
#include <utility>
#include <vector>

#include "net/mesh_router.hpp"
#include "net/transport_decorator.hpp"

namespace ringsplat {

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
    std::vector<std::vector<LinkCounts>> counts;  ///< by rank
    std::vector<bool> reported;
    int reports_missing;
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
