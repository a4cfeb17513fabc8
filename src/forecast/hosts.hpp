#pragma once
#include <vector>

#include "ringsplat/net/layout.hpp"
#include "simulate/machine.hpp"

/// What ranks share that are on one host; they fill hosts one after another.
namespace ringsplat::app {

class Hosts {
 public:
  Hosts(const Machine& machine, const Layout& layout);

  /// Whether more ranks work than there are cores.
  bool share_cores() const;
  /// The longest of all hosts' work over its cores. `seconds`: by rank.
  double shared_seconds(const std::vector<double>& seconds) const;
  /// Seconds of the busiest link, which at best is busy all the time, when GPs send Renderers so many bytes
  /// together, each of them as much.
  double link_seconds(double bytes) const;

 private:
  std::size_t host_of(int rank) const;

  const Machine& machine_;
  const Layout& layout_;
  int hosts_;
};

}  // namespace ringsplat::app
