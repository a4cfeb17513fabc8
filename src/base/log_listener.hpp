#pragma once
#include <functional>
#include <string>

namespace ringsplat {

/// Passes warnings and errors of the log to `listener` as well; an empty one ends that. It is called by every
/// thread that logs.
void set_log_listener(std::function<void(const std::string& text)> listener);

}  // namespace ringsplat
