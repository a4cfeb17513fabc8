#include "simulate/simgrid/transfer_log.hpp"

#include <algorithm>

namespace ringsplat::simgrid_platform {

const Transfer& TransferLog::started(double now, double bytes,
                                     const std::vector<simgrid::s4u::Link*>& links) {
  Transfer transfer{.start = now, .bytes = bytes, .latency = 0, .bandwidth = 1e300, .links = links};
  for (const auto* link : links) {
    transfer.latency += link->get_latency();
    transfer.bandwidth = std::min(transfer.bandwidth, link->get_bandwidth() / speedup_);
  }
  under_way_.emplace(Key(now, bytes), transfers_.size());
  transfers_.push_back(std::move(transfer));
  return transfers_.back();
}

void TransferLog::ended(const simgrid::kernel::resource::Action& action) {
  const auto found = under_way_.find({action.get_start_time(), action.get_cost()});
  if (found == under_way_.end()) return;
  Transfer& transfer = transfers_[found->second];
  transfer.taken = action.get_finish_time() - action.get_start_time();
  if (action.get_finish_time() != last_end_) just_ended_.clear();
  last_end_ = action.get_finish_time();
  just_ended_.emplace(Key(last_end_, transfer.bytes), found->second);
  under_way_.erase(found);
}

void TransferLog::received_payload(double now, double bytes) {
  const auto found = just_ended_.find({now, bytes});
  if (found == just_ended_.end()) return;
  transfers_[found->second].payload = true;
  just_ended_.erase(found);
}

std::vector<const Transfer*> TransferLog::payloads() const {
  std::vector<const Transfer*> some;
  for (const Transfer& transfer : transfers_)
    if (transfer.payload) some.push_back(&transfer);
  return some;
}

}  // namespace ringsplat::simgrid_platform
