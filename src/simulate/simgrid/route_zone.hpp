#pragma once
#include <simgrid/kernel/routing/NetPoint.hpp>
#include <simgrid/kernel/routing/NetZoneImpl.hpp>
#include <simgrid/s4u.hpp>

#include <functional>
#include <string>
#include <vector>

namespace ringsplat::simgrid_platform {

using Links = std::vector<simgrid::s4u::Link*>;

/// Hosts n0, n1, ... and a function that lists the links from one to another. SimGrid has no zone for a mesh
/// whose messages turn once.
class RouteZone final : public simgrid::kernel::routing::NetZoneImpl {
 public:
  using Way = std::function<Links(int from, int to)>;
  explicit RouteZone(const std::string& name) : NetZoneImpl(name) {}

  simgrid::s4u::Host* add_host(int index, double speed);
  /// One direction of a wire.
  simgrid::s4u::Link* add_link(const std::string& name, double bandwidth, double latency);
  void set_way(Way way) { way_ = std::move(way); }

  void get_local_route(const simgrid::kernel::routing::NetPoint* from,
                       const simgrid::kernel::routing::NetPoint* to, simgrid::kernel::routing::Route* route,
                       double* latency) override;

 private:
  std::vector<int> host_of_point_;  ///< by netpoint id
  Way way_;
};

}  // namespace ringsplat::simgrid_platform
