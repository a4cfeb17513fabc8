#pragma once
#include <condition_variable>
#include <cstdio>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "volume/forwarding_source.hpp"

namespace ringsplat::app {

/// Shows on stderr how far a long piece of work is, once it has taken two seconds: a redrawn bar on a
/// terminal, else a line every few seconds. A thread of its own draws, so that time passes on the display
/// even while the work does not report. Safe to call from several threads.
class Progress {
 public:
  /// When `silent`, shows no progress. `results` is where print() writes.
  explicit Progress(bool silent = false, std::FILE* results = stdout);
  /// Where progress and results go instead of a terminal, on the thread that reports. May throw to end the
  /// work.
  struct Listener {
    std::function<void(const std::string& what, double done, double total)> at;
    std::function<void(const std::string& line)> print;
  };
  explicit Progress(Listener listener);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Starts a piece of work of `total` units; 0 when that is not known.
  void begin(const std::string& what, double total);
  void at(double done);  ///< units done so far
  void end();
  /// Shows until go_on() that the run waits for `what`, as in "waiting for views"; off a terminal prints it
  /// only once. The time shown counts from go_on().
  void wait_for(const std::string& what);
  void go_on() { wait_for({}); }
  /// Writes a line of results without the bar getting into it.
  void print(const std::string& line);
  /// Removes the bar, so that others can write to stderr.
  void clear();

 private:
  void watch();
  void draw();
  void start_clock();
  void wipe();

  const bool silent_, terminal_;
  const Listener listener_;
  std::FILE* const results_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string what_, waiting_for_;
  double total_ = 0, done_ = 0, started_ = 0, drawn_at_ = 0;
  bool working_ = false, said_waiting_ = false, stop_ = false, on_screen_ = false;
  std::thread thread_;
};

/// "[#########...........]  45 %  rendering, 12 s left"; without a total "rendering, 12 s so far". Pure, for
/// Progress.
std::string progress_text(const std::string& what, double done, double total, double seconds);

/// A source that tells a progress bar how far it was read.
class WatchedSource final : public ForwardingSource {
 public:
  WatchedSource(std::unique_ptr<VolumeSource> source, Progress& progress)
      : ForwardingSource(std::move(source)), progress_(progress) {}
  void read_slices(int first, int count, std::span<std::byte> out) override {
    ForwardingSource::read_slices(first, count, out);
    progress_.at(first + count);
  }

 private:
  Progress& progress_;
};

}  // namespace ringsplat::app
