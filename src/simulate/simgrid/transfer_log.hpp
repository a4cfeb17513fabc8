#pragma once
#include <simgrid/kernel/resource/Action.hpp>
#include <simgrid/s4u.hpp>

#include <map>
#include <utility>
#include <vector>

namespace ringsplat::simgrid_platform {

/// One transfer; times are seconds of the simulated clock.
struct Transfer {
  double start = 0;
  double bytes = 0;
  double latency = 0;    ///< sum over the links
  double bandwidth = 0;  ///< of the slowest link
  std::vector<simgrid::s4u::Link*> links;
  double taken = 0;  ///< from start to end; 0 while it is under way
  bool payload = false;

  double alone() const { return latency + bytes / bandwidth; }  ///< seconds without other traffic
  double waited() const { return taken - alone(); }
};

/// All transfers: how long they took, and which of them carried payloads.
///
/// SimGrid reports in pieces: at a transfer's start its links, at its end its start and size, and at the copy
/// to the receiver the size and the bytes. Transfers of the same size that start, or end, at the same instant
/// are matched in order, so sums are right.
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
