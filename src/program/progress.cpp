#include "program/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <utility>

#include "base/clock.hpp"

namespace ringsplat::app {
namespace {

constexpr double patience = 2.0;        ///< seconds before anything is printed
constexpr double redraw_seconds = 0.2;  ///< on a terminal
constexpr double line_seconds = 5.0;    ///< elsewhere

}  // namespace

std::string progress_text(const std::string& what, double done, double total, double seconds) {
  if (!(total > 0) || !(done > 0)) return fmt::format("{}, {:.0f} s so far", what, seconds);
  constexpr int width = 30;
  const double part = std::clamp(done / total, 0.0, 1.0);
  const auto filled = static_cast<std::size_t>(part * width);
  return fmt::format("[{}{}] {:3.0f} %  {}, {:.0f} s left", std::string(filled, '#'),
                     std::string(width - filled, '.'), 100 * part, what, seconds * (1 - part) / part);
}

Progress::Progress(bool silent, std::FILE* results)
    : silent_(silent), terminal_(isatty(STDERR_FILENO) == 1), results_(results) {
  if (!silent_) thread_ = std::thread([this] { watch(); });
}

Progress::Progress(Listener listener)
    : silent_(true), terminal_(false), listener_(std::move(listener)), results_(stdout) {}

Progress::~Progress() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    wipe();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void Progress::begin(const std::string& what, double total) {
  if (listener_.at) listener_.at(what, 0, total);
  const std::lock_guard lock(mutex_);
  what_ = what;
  total_ = total;
  done_ = 0;
  waiting_for_.clear();
  start_clock();
  working_ = true;
}

void Progress::start_clock() {
  started_ = now_seconds();
  drawn_at_ = 0;
}

void Progress::wait_for(const std::string& what) {
  const std::lock_guard lock(mutex_);
  wipe();
  waiting_for_ = what;
  start_clock();
}

void Progress::at(double done) {
  std::string what;
  double total = 0;
  {
    const std::lock_guard lock(mutex_);
    done_ = done;
    if (!listener_.at) return;
    what = what_;
    total = total_;
  }
  listener_.at(what, done, total);
}

void Progress::end() {
  const std::lock_guard lock(mutex_);
  working_ = false;
  wipe();
}

void Progress::print(const std::string& line) {
  if (listener_.print) return listener_.print(line);
  const std::lock_guard lock(mutex_);
  wipe();
  std::fprintf(results_, "%s\n", line.c_str());
  std::fflush(results_);
}

void Progress::clear() {
  const std::lock_guard lock(mutex_);
  wipe();
}

void Progress::watch() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    changed_.wait_for(lock, std::chrono::duration<double>(redraw_seconds), [this] { return stop_; });
    if (working_ && !stop_) draw();
  }
}

void Progress::draw() {
  const double now = now_seconds();
  if (now - started_ < patience || now - drawn_at_ < (terminal_ ? redraw_seconds / 2 : line_seconds)) return;
  const bool waiting = !waiting_for_.empty();
  if (waiting && !terminal_ && std::exchange(said_waiting_, true)) return;
  drawn_at_ = now;
  const std::string text = waiting ? waiting_for_ : progress_text(what_, done_, total_, now - started_);
  std::fprintf(stderr, terminal_ ? "\r%s\x1b[K" : "ringsplat: %s\n", text.c_str());
  std::fflush(stderr);
  on_screen_ = terminal_;
}

void Progress::wipe() {
  if (!on_screen_) return;
  std::fputs("\r\x1b[K", stderr);
  std::fflush(stderr);
  on_screen_ = false;
}

}  // namespace ringsplat::app
