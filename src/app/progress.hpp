#pragma once
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <string>
#include <thread>

namespace ringsplat::app {

/// Says on stderr how far a long piece of work is, once it has taken two seconds: a bar that is
/// redrawn on a terminal, else a line every few seconds. A thread of its own draws, so that it shows time
/// passing also while the work does not come back to report. Safe to call from several threads.
class Progress {
 public:
  /// A silent one says nothing of progress. `results` is where print() writes.
  explicit Progress(bool silent = false, std::FILE* results = stdout);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Starts a piece of work of `total` units; 0 when that is not known.
  void begin(const std::string& what, double total);
  void at(double done);  ///< units done so far
  void end();
  /// Until go_on() nothing is done but to wait, for `what`: "waiting for views". That is said on a terminal,
  /// elsewhere only once. Time passed counts from go_on().
  void wait_for(const std::string& what);
  void go_on();
  /// Writes a line of results without the bar getting into it.
  void print(const std::string& line);
  /// Takes the bar off the screen, for what others write to stderr.
  void clear();

 private:
  void watch();
  void draw();
  void start_clock();
  void wipe();

  const bool silent_, terminal_;
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

}  // namespace ringsplat::app
