#pragma once
#include <functional>
#include <memory>

#include "net/loopback.hpp"
#include "protocol/engine.hpp"
#include "protocol/frame_source.hpp"
#include "protocol/protocol_options.hpp"
#include "ringsplat/net/layout.hpp"

namespace ringsplat {

/// Runs all ranks of a layout in this thread until the source has no more frames. `make_engine(rank)` makes
/// each rank's engine. With `loopback.reorder` the ranks' turns are shuffled too. Throws RunError that says
/// who waits for whom when no rank can move and no message on its way can change that.
void run_loopback(const Layout& layout, const ProtocolOptions& options,
                  const std::function<std::unique_ptr<Engine>(int rank)>& make_engine, FrameSource& source,
                  const LoopbackOptions& loopback = {});

}  // namespace ringsplat
