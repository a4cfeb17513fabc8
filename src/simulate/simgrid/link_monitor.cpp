#include "simulate/simgrid/link_monitor.hpp"

#include <fmt/format.h>
#include <smpi/smpi.h>
#include <simgrid/kernel/resource/Action.hpp>
#include <simgrid/kernel/resource/NetworkModelIntf.hpp>

#include <algorithm>
#include <cstring>
#include <map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "base/log.hpp"
#include "base/output_file.hpp"
#include "net/message.hpp"
#include "ringsplat/base/error.hpp"
#include "simulate/counted_payload.hpp"

namespace ringsplat::simgrid_platform {
namespace {

namespace s4u = simgrid::s4u;

/// One transfer; times are seconds of the simulated clock.
struct Transfer {
  double start = 0;
  double bytes = 0;
  double latency = 0;    ///< sum over the links
  double bandwidth = 0;  ///< of the slowest link
  std::vector<s4u::Link*> links;
  double taken = 0;  ///< from start to end; 0 while it is under way
  bool payload = false;

  double alone() const { return latency + bytes / bandwidth; }  ///< seconds without other traffic
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
  const Transfer& started(double now, double bytes, const std::vector<s4u::Link*>& links) {
    Transfer transfer{.start = now, .bytes = bytes, .latency = 0, .bandwidth = 1e300, .links = links};
    for (const auto* link : links) {
      transfer.latency += link->get_latency();
      transfer.bandwidth = std::min(transfer.bandwidth, link->get_bandwidth() / speedup_);
    }
    under_way_.emplace(Key(now, bytes), transfers_.size());
    transfers_.push_back(std::move(transfer));
    return transfers_.back();
  }
  void ended(const simgrid::kernel::resource::Action& action) {
    const auto found = under_way_.find({action.get_start_time(), action.get_cost()});
    if (found == under_way_.end()) return;
    Transfer& transfer = transfers_[found->second];
    transfer.taken = action.get_finish_time() - action.get_start_time();
    if (action.get_finish_time() != last_end_) just_ended_.clear();
    last_end_ = action.get_finish_time();
    just_ended_.emplace(Key(last_end_, transfer.bytes), found->second);
    under_way_.erase(found);
  }
  /// The receiver has a payload; `bytes` are those of the transfer that has just ended.
  void received_payload(double now, double bytes) {
    const auto found = just_ended_.find({now, bytes});
    if (found == just_ended_.end()) return;
    transfers_[found->second].payload = true;
    just_ended_.erase(found);
  }

  /// Payloads that arrived, by start.
  std::vector<const Transfer*> payloads() const {
    std::vector<const Transfer*> some;
    for (const Transfer& transfer : transfers_)
      if (transfer.payload) some.push_back(&transfer);
    return some;
  }

 private:
  double speedup_;
  using Key = std::pair<double, double>;  ///< instant and bytes
  std::vector<Transfer> transfers_;
  std::multimap<Key, std::size_t> under_way_;   ///< by start
  std::multimap<Key, std::size_t> just_ended_;  ///< at `last_end_`
  double last_end_ = -1;
};

struct Interval {
  double begin, end;
};

struct LinkUse {
  long payloads = 0, overlaps = 0;
  double bytes = 0, busy = 0;
  std::vector<Interval> open;  ///< intervals that may still overlap a transfer that starts now

  void add(const Transfer& transfer) {
    const Interval here{transfer.start + transfer.latency, transfer.start + transfer.alone()};
    ++payloads;
    bytes += transfer.bytes;
    busy += here.end - here.begin;
    std::erase_if(open, [&](const Interval& other) { return other.end <= transfer.start; });
    constexpr double rounding = 1e-12;
    overlaps += std::any_of(open.begin(), open.end(), [&](const Interval& other) {
      return here.begin < other.end - rounding && other.begin < here.end - rounding;
    });
    open.push_back(here);
  }
};

void write(const std::string& file, const std::string& text) try {
  write_text(file, text);
} catch (const Error& e) {
  log_error("{}", e.what());
}

std::string links_csv(const std::vector<const Transfer*>& payloads) {
  std::map<std::string, LinkUse> uses;
  for (const Transfer* payload : payloads)
    for (const auto* link : payload->links) uses[link->get_name()].add(*payload);
  std::string text = "link,payloads,bytes,busy_seconds,overlaps\n";
  for (const auto& [name, use] : uses)
    text += fmt::format("{},{},{:.0f},{:.9f},{}\n", name, use.payloads, use.bytes, use.busy, use.overlaps);
  return text;
}

std::string transfers_csv(const std::vector<const Transfer*>& payloads) {
  std::string text = "start,bytes,alone,taken\n";
  for (const Transfer* payload : payloads)
    text += fmt::format("{:.12g},{:.0f},{:.12g},{:.12g}\n", payload->start, payload->bytes, payload->alone(),
                        payload->taken);
  return text;
}

/// Null where links are not watched. Never freed: SimGrid calls back until the process ends, when statics may
/// be gone.
TransferLog* payload_log = nullptr;

/// Copies a message to its receiver.
void copy(smx_activity_t transfer, void* buffer, std::size_t size) {
  Header header;
  bool payload = false, counted = false;
  if (size >= sizeof(Header)) {
    std::memcpy(&header, buffer, sizeof(Header));
    counted = header.magic == counted_magic;
    payload = (counted || header.magic == Header{}.magic) && header.kind == Kind::payload;
  }
  constexpr double added_by_smpi = 16;
  if (payload && payload_log != nullptr)
    payload_log->received_payload(s4u::Engine::get_clock(), double(size) + added_by_smpi);
  const std::size_t said = payload && counted ? std::min(size, counted_bytes) : size;
  // SimGrid declares the same type under two names and installs neither.
  smpi_comm_copy_buffer_callback(reinterpret_cast<simgrid::kernel::activity::CommImpl*>(transfer), buffer,
                                 said);
}

}  // namespace

void copy_only_what_counts() { smpi_comm_set_copy_data_callback(copy); }

void watch_links(s4u::NetZone* zone, double speedup, MonitorFiles files) {
  auto* const log = payload_log = new TransferLog(speedup);
  zone->get_network_model()->set_lat_factor_cb(
      [log, speedup](double bytes, const s4u::Host*, const s4u::Host*, const std::vector<s4u::Link*>& links,
                     const std::unordered_set<s4u::NetZone*>&) {
        const Transfer& transfer = log->started(s4u::Engine::get_clock(), bytes, links);
        // Ranks of one host may have no latency between them; nothing waits for their traffic.
        return speedup > 1 && transfer.latency > 0 ? transfer.alone() / transfer.latency : 1.0;
      });
  using simgrid::kernel::resource::Action;
  s4u::Link::on_communication_state_change_cb(
      [log](simgrid::kernel::resource::NetworkAction& transfer, Action::State) {
        // SimGrid installs only a forward declaration of this class; its only base is Action.
        const auto& action = reinterpret_cast<const Action&>(transfer);
        if (action.get_state() == Action::State::FINISHED) log->ended(action);
      });
  s4u::Engine::on_simulation_end_cb([log, files = std::move(files)] {
    const auto payloads = log->payloads();
    if (!files.links.empty()) write(files.links, links_csv(payloads));
    if (!files.transfers.empty()) write(files.transfers, transfers_csv(payloads));
  });
}

}  // namespace ringsplat::simgrid_platform
