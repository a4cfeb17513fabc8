#pragma once
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include "base/clock.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::app {

/// "[#########...........]  45 %  rendering, 12 s left"; without a total "rendering, 12 s so far". Pure, for
/// Progress.
inline std::string progress_text(const std::string& what, double done, double total, double seconds) {
  if (!(total > 0) || !(done > 0)) return fmt::format("{}, {:.0f} s so far", what, seconds);
  constexpr int width = 30;
  const double part = std::clamp(done / total, 0.0, 1.0);
  const auto filled = static_cast<std::size_t>(part * width);
  return fmt::format("[{}{}] {:3.0f} %  {}, {:.0f} s left", std::string(filled, '#'),
                     std::string(width - filled, '.'), 100 * part, what, seconds * (1 - part) / part);
}

/// Shows on stderr how far a long piece of work is, once it has taken two seconds: a redrawn bar on a
/// terminal, else a line every few seconds. A thread of its own draws, so that time passes on the display
/// even while the work does not report. Safe to call from several threads.
class Progress {
 public:
  /// When `silent`, shows no progress. `results` is where print() writes.
  explicit Progress(bool silent = false, std::FILE* results = stdout)
      : terminal_(isatty(STDERR_FILENO) == 1), results_(results) {
    if (!silent) thread_ = std::jthread([this](const std::stop_token& stop) { watch(stop); });
  }
  /// Where progress and results go instead of a terminal, on the thread that reports. May throw to end the
  /// work.
  struct Listener {
    std::function<void(const std::string& what, double done, double total)> at;
    std::function<void(const std::string& line)> print;
  };
  explicit Progress(Listener listener) : terminal_(false), listener_(std::move(listener)), results_(stdout) {}
  ~Progress() {
    const std::lock_guard lock(mutex_);
    thread_.request_stop();
    wipe();
  }

  /// Starts a piece of work of `total` units; 0 when that is not known.
  void begin(const std::string& what, double total) {
    if (listener_.at) listener_.at(what, 0, total);
    const std::lock_guard lock(mutex_);
    what_ = what;
    total_ = total;
    done_ = 0;
    started_ = now_seconds();
    drawn_at_ = 0;
    working_ = true;
  }
  /// Units done so far.
  void at(double done) {
    std::unique_lock lock(mutex_);
    done_ = done;
    if (!listener_.at) return;
    const auto [what, total] = std::pair(what_, total_);
    lock.unlock();
    listener_.at(what, done, total);
  }
  void end() {
    const std::lock_guard lock(mutex_);
    working_ = false;
    wipe();
  }
  /// Writes a line of results without the bar getting into it.
  void print(const std::string& line) {
    if (listener_.print) return listener_.print(line);
    const std::lock_guard lock(mutex_);
    wipe();
    std::fprintf(results_, "%s\n", line.c_str());
    std::fflush(results_);
  }
  /// Removes the bar, so that others can write to stderr.
  void clear() {
    const std::lock_guard lock(mutex_);
    wipe();
  }

 private:
  static constexpr double patience = 2.0;        ///< seconds before anything is printed
  static constexpr double redraw_seconds = 0.2;  ///< on a terminal
  static constexpr double line_seconds = 5.0;    ///< elsewhere

  void watch(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (!stop.stop_requested()) {
      changed_.wait_for(lock, stop, std::chrono::duration<double>(redraw_seconds), [] { return false; });
      if (working_ && !stop.stop_requested()) draw();
    }
  }

  void draw() {
    const double now = now_seconds();
    if (now - started_ < patience || now - drawn_at_ < (terminal_ ? redraw_seconds / 2 : line_seconds))
      return;
    drawn_at_ = now;
    const std::string text = progress_text(what_, done_, total_, now - started_);
    std::fprintf(stderr, terminal_ ? "\r%s\x1b[K" : "ringsplat: %s\n", text.c_str());
    std::fflush(stderr);
    on_screen_ = terminal_;
  }

  void wipe() {
    if (!on_screen_) return;
    std::fputs("\r\x1b[K", stderr);
    std::fflush(stderr);
    on_screen_ = false;
  }

  const bool terminal_;
  const Listener listener_;
  std::FILE* const results_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::string what_;
  double total_ = 0, done_ = 0, started_ = 0, drawn_at_ = 0;
  bool working_ = false, on_screen_ = false;
  std::jthread thread_;  ///< last: its end waits for the thread, which uses all of the above
};

/// A source that tells how far it was read.
class WatchedSource final : public ForwardingSource {
 public:
  WatchedSource(std::unique_ptr<VolumeSource> source, std::function<void(int slices)> at)
      : ForwardingSource(std::move(source)), at_(std::move(at)) {}
  void read_slices(int first, int count, std::span<std::byte> out) override {
    ForwardingSource::read_slices(first, count, out);
    at_(first + count);
  }

 private:
  const std::function<void(int slices)> at_;
};

}  // namespace ringsplat::app
