#include "link_monitor.hpp"

#include <simgrid/kernel/resource/NetworkModelIntf.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <unordered_set>
#include <vector>

namespace ringsplat::simgrid_platform {
namespace {

namespace s4u = simgrid::s4u;

struct Interval {
  double begin, end;
};

struct LinkUse {
  long payloads = 0, overlaps = 0;
  double bytes = 0, busy = 0;
  std::vector<Interval> open;  ///< that may still overlap what starts now
};

class Monitor {
 public:
  Monitor(const Layout& layout, std::string file) : layout_(layout), file_(std::move(file)) {}

  /// SimGrid calls it for every transfer that starts; returns the factor on its latency.
  double started(double size, const s4u::Host* from, const s4u::Host* to,
                 const std::vector<s4u::Link*>& links) {
    if (is_payload(size, from, to)) note(size, links);
    return 1.0;
  }

  void write() const {
    std::FILE* const out = std::fopen(file_.c_str(), "w");
    if (out == nullptr) {
      std::fprintf(stderr, "ringsplat: error: %s cannot be written\n", file_.c_str());
      return;
    }
    std::fprintf(out, "link,payloads,bytes,busy_seconds,overlaps\n");
    for (const auto& [name, use] : uses_)
      std::fprintf(out, "%s,%ld,%.0f,%.9f,%ld\n", name.c_str(), use.payloads, use.bytes, use.busy,
                   use.overlaps);
    std::fclose(out);
  }

 private:
  bool is_payload(double size, const s4u::Host* from, const s4u::Host* to) const {
    // SimGrid adds 16 bytes to a message of its simulated MPI.
    constexpr double longest_without_body = sizeof(Header) + 16;
    const auto index = [](const s4u::Host* host) { return std::atoi(host->get_cname() + 1); };
    return size > longest_without_body && index(from) < layout_.gps && index(to) >= layout_.gps;
  }

  void note(double size, const std::vector<s4u::Link*>& links) {
    const double now = s4u::Engine::get_clock();
    double latency = 0, bandwidth = 1e300;
    for (const auto* link : links) {
      latency += link->get_latency();
      bandwidth = std::min(bandwidth, link->get_bandwidth());
    }
    const Interval here{now + latency, now + latency + size / bandwidth};
    for (const auto* link : links) {
      LinkUse& use = uses_[link->get_name()];
      ++use.payloads;
      use.bytes += size;
      use.busy += here.end - here.begin;
      std::erase_if(use.open, [&](const Interval& other) { return other.end <= now; });
      constexpr double rounding = 1e-12;
      use.overlaps += std::any_of(use.open.begin(), use.open.end(), [&](const Interval& other) {
        return here.begin < other.end - rounding && other.begin < here.end - rounding;
      });
      use.open.push_back(here);
    }
  }

  Layout layout_;
  std::string file_;
  std::map<std::string, LinkUse> uses_;
};

}  // namespace

void watch_links(s4u::NetZone* zone, const Layout& layout, std::string file) {
  // Never freed: SimGrid calls back until the process ends, when statics may be gone.
  auto* const monitor = new Monitor(layout, std::move(file));
  zone->get_network_model()->set_lat_factor_cb(
      [monitor](double size, const s4u::Host* from, const s4u::Host* to, const std::vector<s4u::Link*>& links,
                const std::unordered_set<s4u::NetZone*>&) {
        return monitor->started(size, from, to, links);
      });
  s4u::Engine::on_simulation_end_cb([monitor] { monitor->write(); });
}

}  // namespace ringsplat::simgrid_platform
