#include "forecast/hosts.hpp"

#include <algorithm>

#include "net/message.hpp"

namespace ringsplat::app {

Hosts::Hosts(const Machine& machine, const Layout& layout)
    : machine_(machine),
      layout_(layout),
      hosts_(machine.platform.hosts > 0 ? machine.platform.hosts
                                        : (layout.ranks() - 1) / machine.platform.cores + 1) {}

std::size_t Hosts::host_of(int rank) const {
  return std::size_t(machine_.platform.hosts > 0 ? std::int64_t{rank} * hosts_ / layout_.ranks()
                                                 : rank / machine_.platform.cores);
}

bool Hosts::share_cores() const { return shares_cores(machine_, layout_.working_ranks()); }

double Hosts::shared_seconds(const std::vector<double>& seconds) const {
  std::vector<double> work(std::size_t(hosts_), 0.0);
  for (std::size_t rank = 0; rank < seconds.size(); ++rank) work[host_of(int(rank))] += seconds[rank];
  return *std::max_element(work.begin(), work.end()) / machine_.platform.cores;
}

double Hosts::link_seconds(double bytes) const {
  const auto& platform = machine_.platform;
  if (platform.kind != PlatformKind::backbone && platform.kind != PlatformKind::fat_tree) return 0;
  std::vector<double> gps(std::size_t(hosts_), 0.0), renderers = gps;
  for (int g = 0; g < layout_.gps; ++g) gps[host_of(layout_.rank_of({Role::gp, g}))] += 1.0 / layout_.gps;
  for (int r = 0; r < layout_.renderers; ++r)
    renderers[host_of(layout_.rank_of({Role::renderer, r}))] += 1.0 / layout_.renderers;
  double most_of_host = 0, between_hosts = 0;
  for (std::size_t h = 0; h < gps.size(); ++h) {
    const double out = gps[h] * (1 - renderers[h]), in = renderers[h] * (1 - gps[h]);
    most_of_host = std::max({most_of_host, out, in});
    between_hosts += out;
  }
  const double shared =
      platform.backbone_bandwidth > 0 ? between_hosts * bytes / platform.backbone_bandwidth : 0;
  return std::max(most_of_host * bytes / platform.bandwidth, shared);
}

}  // namespace ringsplat::app
