#include "base/log.hpp"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <mutex>
#include <set>
#include <utility>

#include "base/lack_of_memory.hpp"
#include "base/log_to_stderr.hpp"
#include "base/printable.hpp"

namespace ringsplat {
namespace {

spdlog::logger& logger() {
  static const auto shared = [] {
    auto made =
        std::make_shared<spdlog::logger>("ringsplat", std::make_shared<spdlog::sinks::stderr_sink_mt>());
    made->set_pattern("ringsplat: %l: %v");
    return made;
  }();
  return *shared;
}

bool is_first_rank = true;

std::function<void(LogLevel, const std::string&)>& log_sink() {
  static std::function<void(LogLevel, const std::string&)> sink;
  return sink;
}

spdlog::level::level_enum to_spdlog(LogLevel level) {
  switch (level) {
    case LogLevel::debug:
      return spdlog::level::debug;
    case LogLevel::info:
      return spdlog::level::info;
    case LogLevel::warning:
      return spdlog::level::warn;
    case LogLevel::error:
      return spdlog::level::err;
  }
  return spdlog::level::err;
}

}  // namespace

void set_log_rank(int rank, bool verbose) {
  is_first_rank = rank == 0;
  const std::string named = rank == 0 && !verbose ? "" : fmt::format(" [rank {}]", rank);
  logger().set_pattern(fmt::format("ringsplat{}: %l: %v", named));
  name_in_lack_of_memory(named);
  logger().set_level(verbose ? spdlog::level::debug : rank == 0 ? spdlog::level::info : spdlog::level::warn);
}

void set_log_sink(std::function<void(LogLevel level, const std::string& text)> sink) {
  log_sink() = std::move(sink);
}

void log_to_stderr(LogLevel level, const std::string& text) {
  logger().log(to_spdlog(level), printable(text));
}

void log_line(LogLevel level, const std::string& text) {
  if (log_sink())
    log_sink()(level, printable(text));
  else
    log_to_stderr(level, text);
}

void log_line_once(LogLevel level, const std::string& text) {
  if (!is_first_rank) return;
  static std::mutex mutex;
  static std::set<std::string> said;
  {
    const std::lock_guard lock(mutex);
    if (!said.insert(text).second) return;
  }
  log_line(level, text);
}

}  // namespace ringsplat
