#include "simulate/simgrid/link_monitor.hpp"

#include <fmt/format.h>
#include <simgrid/kernel/resource/NetworkModelIntf.hpp>

#include <algorithm>
#include <cstdio>
#include <map>
#include <unordered_set>
#include <vector>

#include "simulate/simgrid/payload_copies.hpp"
#include "simulate/simgrid/transfer_log.hpp"

namespace ringsplat::simgrid_platform {
namespace {

namespace s4u = simgrid::s4u;

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

void write(const std::string& file, const std::string& text) {
  const std::string beside = file + ".part";
  std::FILE* const out = std::fopen(beside.c_str(), "w");
  const bool written = out != nullptr && std::fputs(text.c_str(), out) >= 0;
  const bool closed = out != nullptr && std::fclose(out) == 0;
  if (!written || !closed || std::rename(beside.c_str(), file.c_str()) != 0)
    std::fprintf(stderr, "ringsplat: error: %s cannot be written\n", file.c_str());
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

}  // namespace

void watch_links(s4u::NetZone* zone, double speedup, MonitorFiles files) {
  // Never freed: SimGrid calls back until the process ends, when statics may be gone.
  auto* const log = new TransferLog(speedup);
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
  on_payload_copied([log](std::size_t bytes) {
    constexpr double added_by_smpi = 16;
    log->received_payload(s4u::Engine::get_clock(), double(bytes) + added_by_smpi);
  });
  s4u::Engine::on_simulation_end_cb([log, files = std::move(files)] {
    const auto payloads = log->payloads();
    if (!files.links.empty()) write(files.links, links_csv(payloads));
    if (!files.transfers.empty()) write(files.transfers, transfers_csv(payloads));
  });
}

}  // namespace ringsplat::simgrid_platform
