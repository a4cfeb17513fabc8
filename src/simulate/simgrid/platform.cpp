// A SimGrid platform made from a machine of mpi_configs/machines, for smpirun -platform. scripts/simulate.sh
// sets the machine, the number of ranks and a mesh's layout by environment variables.
#include <fmt/format.h>
#include <smpi/smpi.h>
#include <simgrid/kernel/routing/NetPoint.hpp>
#include <simgrid/kernel/routing/NetZoneImpl.hpp>
#include <simgrid/s4u.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>

#include "net/mesh.hpp"
#include "net/message.hpp"
#include "ringsplat/base/error.hpp"
#include "simulate/counted_payload.hpp"
#include "simulate/machine.hpp"

namespace ringsplat::simgrid_platform {
namespace {

namespace routing = simgrid::kernel::routing;
namespace s4u = simgrid::s4u;

/// Speed of a core. Any number does, since charges are in seconds.
constexpr double speed = 1e9;
constexpr double no_limit = 1e15;

std::string setting(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

int count_setting(const char* name) {
  const std::string text = setting(name);
  const int value = std::atoi(text.c_str());
  if (value < 1)
    throw InputError(fmt::format("{} is '{}', not a count", name, text), "start with scripts/simulate.sh");
  return value;
}

struct Job {
  Machine machine;
  int ranks;
  Layout layout;

  int hosts() const {
    const auto& platform = machine.platform;
    return platform.hosts > 0 ? platform.hosts : (ranks + platform.cores - 1) / platform.cores;
  }
};

Job read_job() {
  Job job{read_machine(setting("RINGSPLAT_MACHINE")), count_setting("RINGSPLAT_RANKS"), {}};
  job.layout.gps = count_setting("RINGSPLAT_GPS");
  job.layout.renderers = count_setting("RINGSPLAT_RENDERERS");
  if (const std::string mesh = setting("RINGSPLAT_MESH"); !mesh.empty()) {
    int columns = 0, rows = 0;
    if (std::sscanf(mesh.c_str(), "%dx%d", &columns, &rows) != 2)
      throw InputError(fmt::format("RINGSPLAT_MESH is '{}', not COLUMNSxROWS", mesh),
                       "start with scripts/simulate.sh");
    job.layout = mesh_layout(columns, rows, job.layout.renderers);
    check(job.layout);
  }
  return job;
}

/// The link between ranks that share a host.
template <class Zone>
s4u::Link* add_local_link(Zone& zone, const std::string& name, const Job& job) {
  const auto& platform = job.machine.platform;
  auto* const link =
      zone.create_link(name, {platform.local_bandwidth > 0 ? platform.local_bandwidth : no_limit});
  link->set_latency(platform.local_latency);
  link->set_sharing_policy(s4u::Link::SharingPolicy::FATPIPE);
  return link;
}

using Links = std::vector<s4u::Link*>;

/// Hosts n0, n1, ... and a function that lists the links from one to another. SimGrid has no zone for a mesh
/// whose messages turn once.
class RouteZone final : public routing::NetZoneImpl {
 public:
  using Way = std::function<Links(int from, int to)>;
  explicit RouteZone(const Job& job) : NetZoneImpl("machine") {
    for (int index = 0; index < job.hosts(); ++index) {
      auto* const host = create_host(fmt::format("n{}", index), {speed});
      host->set_core_count(job.machine.platform.cores);
      index_of_[host->get_netpoint()] = index;
    }
  }
  void set_way(Way way) { way_ = std::move(way); }

  void get_local_route(const routing::NetPoint* from, const routing::NetPoint* to, routing::Route* route,
                       double* latency) override {
    for (const auto* link : way_(index_of_.at(from), index_of_.at(to))) {
      route->link_list_.push_back(link->get_impl());
      if (latency != nullptr) *latency += link->get_latency();
    }
  }

 private:
  std::map<const routing::NetPoint*, int> index_of_;  ///< of each host
  Way way_;
};

s4u::NetZone* backbone(const Job& job) {
  auto& zone = *new RouteZone(job);  // SimGrid's engine owns it
  const auto& platform = job.machine.platform;
  Links out, in;
  for (int host = 0; host < job.hosts(); ++host) {
    out.push_back(zone.create_link(fmt::format("n{}-out", host), {platform.bandwidth}));
    out.back()->set_latency(platform.latency);
    in.push_back(zone.create_link(fmt::format("n{}-in", host), {platform.bandwidth}));
  }
  s4u::Link* const shared =
      platform.backbone_bandwidth > 0 ? zone.create_link("backbone", {platform.backbone_bandwidth}) : nullptr;
  s4u::Link* const local = add_local_link(zone, "local", job);
  zone.set_way([=](int from, int to) {
    if (from == to) return Links{local};
    return shared != nullptr ? Links{out[std::size_t(from)], shared, in[std::size_t(to)]}
                             : Links{out[std::size_t(from)], in[std::size_t(to)]};
  });
  return zone.get_iface();
}

NodeId node_on(const Layout& layout, int rank) {
  return rank < layout.gps ? NodeId{Role::gp, rank} : NodeId{Role::renderer, rank - layout.gps};
}

s4u::NetZone* mesh(const Job& job) {
  if (job.layout.topology != Topology::mesh || job.hosts() != job.ranks)
    throw InputError("a mesh machine runs a mesh of ranks, one on a host",
                     "add topology and mesh to the configuration");
  auto& zone = *new RouteZone(job);  // SimGrid's engine owns it
  const auto& platform = job.machine.platform;
  std::map<Link, s4u::Link*> wires;
  for (const Link& link : links(job.layout))
    wires[link] =
        zone.create_link(name(job.layout, link), {platform.bandwidth})->set_latency(platform.latency);
  s4u::Link* const local = add_local_link(zone, "local", job);
  zone.set_way([layout = job.layout, wires, local](int from, int to) {
    if (from == to) return Links{local};
    Links way;
    for (const Hop& hop : route(layout, node_on(layout, from), node_on(layout, to)))
      way.push_back(wires.at(hop.link));
    return way;
  });
  return zone.get_iface();
}

s4u::ClusterCallbacks cluster_hosts(const Job& job) {
  return {[job](s4u::NetZone* zone, const std::vector<unsigned long>&, unsigned long id) {
            auto* const host = zone->create_host(fmt::format("n{}", id), speed);
            host->set_core_count(job.machine.platform.cores);
            host->seal();
            return std::make_pair(host->get_netpoint(),
                                  static_cast<simgrid::kernel::routing::NetPoint*>(nullptr));
          },
          [job](s4u::NetZone* zone, const std::vector<unsigned long>&, unsigned long id) {
            auto* const link = add_local_link(*zone, fmt::format("local{}", id), job);
            link->seal();
            return link;
          },
          {}};
}

s4u::NetZone* torus(const Job& job) {
  const auto columns = static_cast<unsigned long>(std::ceil(std::sqrt(job.hosts())));
  const auto rows = (static_cast<unsigned long>(job.hosts()) + columns - 1) / columns;
  return s4u::create_torus_zone("machine", nullptr, {columns, rows}, cluster_hosts(job),
                                job.machine.platform.bandwidth, job.machine.platform.latency,
                                s4u::Link::SharingPolicy::SPLITDUPLEX);
}

s4u::NetZone* fat_tree(const Job& job) {
  const auto leaf = static_cast<unsigned>(std::min(job.machine.platform.leaf, job.hosts()));
  const unsigned leaves = (static_cast<unsigned>(job.hosts()) + leaf - 1) / leaf;
  return s4u::create_fatTree_zone("machine", nullptr, {2, {leaf, leaves}, {1, leaf}, {1, 1}},
                                  cluster_hosts(job), job.machine.platform.bandwidth,
                                  job.machine.platform.latency, s4u::Link::SharingPolicy::SPLITDUPLEX);
}

/// Copies a message to its receiver: of a payload that only counts no more than its first bytes, while its
/// true size is charged. Otherwise a large volume's frame moves hundreds of gigabytes through this machine's
/// memory.
void copy_what_counts(smx_activity_t transfer, void* buffer, std::size_t size) {
  Header header;
  if (size >= sizeof(Header)) std::memcpy(&header, buffer, sizeof(Header));
  const bool counted = header.magic == counted_magic && header.kind == Kind::payload;
  // SimGrid declares the same type under two names and installs neither.
  smpi_comm_copy_buffer_callback(reinterpret_cast<simgrid::kernel::activity::CommImpl*>(transfer), buffer,
                                 counted ? std::min(size, counted_bytes) : size);
}

}  // namespace
}  // namespace ringsplat::simgrid_platform

/// Entry point that SimGrid calls in a platform's shared object.
extern "C" void load_platform(const simgrid::s4u::Engine&);
void load_platform(const simgrid::s4u::Engine&) {
  using namespace ringsplat::simgrid_platform;
  try {
    const Job job = read_job();
    constexpr std::array makers{backbone, mesh, torus, fat_tree};  // in PlatformKind's order
    makers[std::size_t(job.machine.platform.kind)](job)->seal();
    smpi_comm_set_copy_data_callback(copy_what_counts);
  } catch (const ringsplat::Error& e) {
    std::fprintf(stderr, "ringsplat: error: %s\n", e.what());
    std::exit(static_cast<int>(e.exit_code()));
  }
}
