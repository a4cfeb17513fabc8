#pragma once
#include <simgrid/kernel/resource/Action.hpp>
#include <simgrid/s4u.hpp>

#include <map>
#include <utility>
#include <vector>

namespace ringsplat::simgrid_platform {

/// Seconds of the simulated clock.
struct Transfer {
  double start = 0;
  double bytes = 0;
  double latency = 0;    ///< of all links
  double bandwidth = 0;  ///< of the slowest
  std::vector<simgrid::s4u::Link*> links;
  double taken = 0;  ///< from start to end; 0 while it is under way
  bool payload = false;

  double alone() const { return latency + bytes / bandwidth; }  ///< taken when it meets no other
  double waited() const { return taken - alone(); }
};

/// Which transfers there were, how long they took, and which of them carried payloads.
///
/// SimGrid tells these things one by one: of a transfer's begin its links, of its end its begin and size, and
/// of what it copies to the receiver the size and the bytes. Of transfers of the same size that begin, or
/// end, at the same instant, the earlier one is taken, so that sums are right.
class TransferLog {
 public:
  /// SimGrid's links are `speedup` times as fast as the described ones.
  explicit TransferLog(double speedup) : speedup_(speedup) {}

  /// The result holds until the next call.
  const Transfer& started(double now, double bytes, const std::vector<simgrid::s4u::Link*>& links);
  void ended(const simgrid::kernel::resource::Action& action);
  /// The receiver has a payload; `bytes` are those of the transfer that has just ended.
  void received_payload(double now, double bytes);

  /// Payloads that arrived, by start.
  std::vector<const Transfer*> payloads() const;

 private:
  double speedup_;
  using Key = std::pair<double, double>;  ///< instant and bytes
  std::vector<Transfer> transfers_;
  std::multimap<Key, std::size_t> under_way_;   ///< by start
  std::multimap<Key, std::size_t> just_ended_;  ///< at `last_end_`
  double last_end_ = -1;
};

}  // namespace ringsplat::simgrid_platform
