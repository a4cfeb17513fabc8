#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "net/message.hpp"
#include "simulate/machine.hpp"

namespace ringsplat::app {

class Hosts {
 public:
  Hosts(const Machine& machine, const Layout& layout)
      : machine_(machine),
        layout_(layout),
        hosts_(machine.platform.hosts > 0 ? machine.platform.hosts
                                          : (layout.ranks() - 1) / machine.platform.cores + 1) {}

  /// Whether more ranks work than there are cores.
  bool share_cores() const { return shares_cores(machine_, layout_.working_ranks()); }
  /// The longest of all hosts' work over its cores. `seconds`: by rank.
  double shared_seconds(const std::vector<double>& seconds) const {
    std::vector<double> work(std::size_t(hosts_), 0.0);
    for (std::size_t rank = 0; rank < seconds.size(); ++rank) work[host_of(int(rank))] += seconds[rank];
    return *std::max_element(work.begin(), work.end()) / machine_.platform.cores;
  }
  /// Seconds of the busiest link, which at best is busy all the time, when GPs send Renderers so many bytes
  /// together, each of them as much.
  double link_seconds(double bytes) const {
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

 private:
  std::size_t host_of(int rank) const {
    return std::size_t(machine_.platform.hosts > 0 ? std::int64_t{rank} * hosts_ / layout_.ranks()
                                                   : rank / machine_.platform.cores);
  }

  const Machine& machine_;
  const Layout& layout_;
  int hosts_;
};

/// What each Renderer draws.
struct Shares {
  /// By layer and Renderer, of a slice: seconds for its payload besides what every payload costs, and seconds
  /// that may be spent later, between payloads.
  std::vector<std::vector<double>> of_layer, painted;
  std::vector<bool> has_tile;
  std::vector<double> pixels;  ///< that it delivers
};

/// Mean hops of messages between neighbours in the order of slices, and between a GP and a Renderer, there
/// and back.
struct MeanHops {
  double token = 1, payload = 1, accept = 1;
};
MeanHops mean_hops(const Layout& layout);

/// What every slice costs, in seconds.
struct TokenCosts {
  double slice = 0, message = 0;  ///< a Renderer, for a slice of a payload, and once for the payload
  double table = 0;               ///< a Renderer, with its first payload
  double hop = 0;                 ///< from sending a message without a payload to having it
  double wake = 0;                ///< until a rank that waited goes on
  double software = 0;            ///< a GP's for a token, its payload and accept
  double longest_piece = 0;       ///< computed before messages are taken
  double painting_piece = 0;      ///< the same, of work between payloads
  double pixel = 0;               ///< to deliver one
  MeanHops hops = {};             ///< of one hop each where messages are not handed on
};
/// What a machine's description says of them; a payload's slices are left out.
TokenCosts token_costs(const Machine& machine, const Layout& layout);

/// All tokens pass a bundle.
struct BundlePass {
  std::size_t gp = 0;
  std::vector<std::size_t> layers;  ///< of its slices
  double encoding = 0;              ///< seconds that its GP needs
};

/// Of one frame, in seconds.
struct TokenTimes {
  double end = 0, busiest_gp = 0, busiest_renderer = 0;
  std::vector<double> busy_ranks;
};

/// When the tokens of one frame pass its slices: followed from slice to slice, Renderer by Renderer. Messages
/// that come to a rank that computes wait for half of its piece.
TokenTimes token_times(const Machine& machine, const Layout& layout, int slots, const Shares& shares,
                       const TokenCosts& costs, const std::vector<BundlePass>& bundles);

}  // namespace ringsplat::app
