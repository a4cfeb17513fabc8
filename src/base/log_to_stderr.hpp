#pragma once
#include <string>

#include "base/log.hpp"

namespace ringsplat {

/// Writes a line as without a sink: for sinks that only listen.
void log_to_stderr(LogLevel level, const std::string& text);

}  // namespace ringsplat
