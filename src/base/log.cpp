#include "base/log.hpp"

#include <cstdio>
#include <mutex>
#include <set>

#include "base/lack_of_memory.hpp"
#include "base/printable.hpp"

namespace ringsplat {
namespace {

int own_rank = 0;
bool says_all = false;

int this_rank() { return log_rank_in_use != nullptr ? log_rank_in_use() : own_rank; }
std::string name_of(int rank) { return rank == 0 && !says_all ? "" : fmt::format(" [rank {}]", rank); }

std::function<void(LogLevel, const std::string&)> log_sink;

}  // namespace

void set_log_rank(int rank, bool verbose) {
  own_rank = rank;
  says_all = verbose;
  name_in_lack_of_memory(name_of(rank));
}

void set_log_sink(std::function<void(LogLevel level, const std::string& text)> sink) {
  log_sink = std::move(sink);
}

void log_to_stderr(LogLevel level, const std::string& text) {
  const int rank = this_rank();
  if (level < (says_all ? LogLevel::debug : rank == 0 ? LogLevel::info : LogLevel::warning)) return;
  constexpr const char* names[] = {"debug", "info", "warning", "error"};
  const std::string line =
      fmt::format("ringsplat{}: {}: {}\n", name_of(rank), names[std::size_t(level)], printable(text));
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
  if (this_rank() != 0) return;
  static std::mutex mutex;
  static std::set<std::string> said;
  {
    const std::lock_guard lock(mutex);
    if (!said.insert(text).second) return;
  }
  log_line(level, text);
}

}  // namespace ringsplat
