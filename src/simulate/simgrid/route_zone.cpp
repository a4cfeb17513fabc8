#include "simulate/simgrid/route_zone.hpp"

#include <fmt/format.h>

namespace ringsplat::simgrid_platform {

namespace routing = simgrid::kernel::routing;

simgrid::s4u::Host* RouteZone::add_host(int index, double speed) {
  auto* const host = create_host(fmt::format("n{}", index), {speed});
  const auto point = std::size_t(host->get_netpoint()->id());
  if (host_of_point_.size() <= point) host_of_point_.resize(point + 1, -1);
  host_of_point_[point] = index;
  return host;
}

simgrid::s4u::Link* RouteZone::add_link(const std::string& name, double bandwidth, double latency) {
  return create_link(name, {bandwidth})->set_latency(latency);
}

void RouteZone::get_local_route(const routing::NetPoint* from, const routing::NetPoint* to,
                                routing::Route* route, double* latency) {
  for (const auto* link :
       way_(host_of_point_.at(std::size_t(from->id())), host_of_point_.at(std::size_t(to->id())))) {
    route->link_list_.push_back(link->get_impl());
    if (latency != nullptr) *latency += link->get_latency();
  }
}

}  // namespace ringsplat::simgrid_platform
