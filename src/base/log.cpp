#include "base/log.hpp"

#include <cstdio>
#include <mutex>
#include <set>

#include "base/lack_of_memory.hpp"
#include "base/printable.hpp"

namespace ringsplat {
namespace {

std::string rank_name;  ///< such as " [rank 3]", where lines have it
LogLevel least_level = LogLevel::info;
bool is_first_rank = true;

std::function<void(LogLevel, const std::string&)> log_sink;

}  // namespace

void set_log_rank(int rank, bool verbose) {
  is_first_rank = rank == 0;
  rank_name = rank == 0 && !verbose ? "" : fmt::format(" [rank {}]", rank);
  name_in_lack_of_memory(rank_name);
  least_level = verbose ? LogLevel::debug : rank == 0 ? LogLevel::info : LogLevel::warning;
}

void set_log_sink(std::function<void(LogLevel level, const std::string& text)> sink) {
  log_sink = std::move(sink);
}

void log_to_stderr(LogLevel level, const std::string& text) {
  if (level < least_level) return;
  constexpr const char* names[] = {"debug", "info", "warning", "error"};
  const std::string line =
      fmt::format("ringsplat{}: {}: {}\n", rank_name, names[std::size_t(level)], printable(text));
  // One call: lines of several threads do not mix.
  std::fwrite(line.data(), 1, line.size(), stderr);
}

void log_line(LogLevel level, const std::string& text) {
  if (log_sink)
    log_sink(level, printable(text));
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
