#pragma once
#include <map>

#include "ringsplat/net/loopback.hpp"
#include "ringsplat/node/host.hpp"

namespace ringsplat {

/// Runs all ranks of a layout in this thread until the director has no more frames. With
/// `loopback.reorder` the ranks' turns are shuffled too. Throws RunError that says who waits for whom
/// when no rank can move and no message on its way can change that.
void run_loopback(const Layout& layout, const ProtocolOptions& options, const Grid& grid,
                  std::map<int, SliceStore> stores, Director director, const LoopbackOptions& loopback = {});

}  // namespace ringsplat
