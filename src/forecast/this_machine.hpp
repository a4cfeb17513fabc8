#pragma once
#include "net/transport.hpp"
#include "simulate/machine.hpp"

namespace ringsplat::app {

/// This machine, as it would be described: the usual costs (frame/work_estimate.hpp) times what GPs and
/// Renderers of either method take here for a small ball, and so many hosts with so many cores each. What
/// they take is measured once, in some tenths of a second, and kept in the user's cache folder for this build
/// on this host.
Machine this_machine(int hosts, int cores);

/// Seconds a message takes to the next rank, measured by one that goes round all ranks many times. All ranks
/// call it, while no other message is on its way; the result is valid on rank 0. Zero with one rank.
double measure_hop(Transport& transport);

}  // namespace ringsplat::app
