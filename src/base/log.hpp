#pragma once
#include <fmt/format.h>

#include <functional>
#include <string>
#include <utility>

/// The log goes to stderr; results go to stdout. Only rank 0 talks unless asked (`set_log_rank`).
namespace ringsplat {

enum class LogLevel { debug, info, warning, error };

/// Names this process in every line; a rank other than 0 says only warnings and errors unless `verbose`.
void set_log_rank(int rank, bool verbose);
/// Passes all lines, of every level, to `sink` instead of stderr; an empty one ends that. Other threads may
/// log, so it is called from them, too.
void set_log_sink(std::function<void(LogLevel level, const std::string& text)> sink);
void log_line(LogLevel level, const std::string& text);
/// Writes a line as without a sink: for sinks that only listen.
void log_to_stderr(LogLevel level, const std::string& text);
/// Logs a text once, on rank 0, and drops it when it comes again. For what is found whenever a file opens.
void log_line_once(LogLevel level, const std::string& text);

template <class... Args>
void log_debug(fmt::format_string<Args...> f, Args&&... args) {
  log_line(LogLevel::debug, fmt::format(f, std::forward<Args>(args)...));
}
template <class... Args>
void log_info(fmt::format_string<Args...> f, Args&&... args) {
  log_line(LogLevel::info, fmt::format(f, std::forward<Args>(args)...));
}
template <class... Args>
void log_warning(fmt::format_string<Args...> f, Args&&... args) {
  log_line(LogLevel::warning, fmt::format(f, std::forward<Args>(args)...));
}
template <class... Args>
void log_warning_once(fmt::format_string<Args...> f, Args&&... args) {
  log_line_once(LogLevel::warning, fmt::format(f, std::forward<Args>(args)...));
}
template <class... Args>
void log_error(fmt::format_string<Args...> f, Args&&... args) {
  log_line(LogLevel::error, fmt::format(f, std::forward<Args>(args)...));
}

}  // namespace ringsplat
