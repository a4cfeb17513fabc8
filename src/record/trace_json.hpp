#pragma once
#include <string>

#include "record/trace.hpp"
#include "ringsplat/net/layout.hpp"

namespace ringsplat {

/// Chrome's trace-event JSON ("Trace Event Format", Google 2016), which Perfetto opens: a process for each
/// rank, a thread for each node, spans as complete events that nest, tokens and payloads as flow arrows.
///
/// Times are microseconds since the first event, exact to the nanosecond. A slice has the children classify,
/// shade and encode: an encoder alternates between them row by row, so each is shown once, with its seconds
/// in sum, one after another. A flow is written only when both of its ends were recorded.
std::string to_chrome_trace(const Trace::Gathered& trace, const Layout& layout);

}  // namespace ringsplat
