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
/// Which rank it is that talks, where several share the process.
inline int (*log_rank_in_use)() = nullptr;
/// Passes all lines, of every level, to `sink` instead of stderr; an empty one ends that. Other threads may
/// log, so it is called from them, too.
void set_log_sink(std::function<void(LogLevel level, const std::string& text)> sink);
void log_line(LogLevel level, const std::string& text);
/// Writes a line as without a sink: for sinks that only listen.
void log_to_stderr(LogLevel level, const std::string& text);
/// Logs a text once, on rank 0, and drops it when it comes again. For what is found whenever a file opens.
void log_line_once(LogLevel level, const std::string& text);

/// Each logs what fmt::format makes of its arguments.
template <LogLevel level, auto log = log_line>
inline constexpr auto log_formatted = []<class... Args>(fmt::format_string<Args...> f, Args&&... args) {
  log(level, fmt::format(f, std::forward<Args>(args)...));
};
inline constexpr auto log_debug = log_formatted<LogLevel::debug>;
inline constexpr auto log_info = log_formatted<LogLevel::info>;
inline constexpr auto log_info_once = log_formatted<LogLevel::info, log_line_once>;
inline constexpr auto log_warning = log_formatted<LogLevel::warning>;
inline constexpr auto log_warning_once = log_formatted<LogLevel::warning, log_line_once>;
inline constexpr auto log_error = log_formatted<LogLevel::error>;

}  // namespace ringsplat
