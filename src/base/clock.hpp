#pragma once
#include <chrono>

namespace ringsplat {

/// The clock of this process, in seconds: the machine's monotonic one, or one that simulates time and was put
/// in its place before anything was timed.
inline double (*clock_in_use)() = [] {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
};
inline double now_seconds() { return clock_in_use(); }

/// Adds the seconds of its lifetime to a counter. One that is null does not even read the clock.
class ScopedSeconds {
 public:
  explicit ScopedSeconds(double* counter) : counter_(counter), start_(counter ? now_seconds() : 0) {}
  ~ScopedSeconds() {
    if (counter_) *counter_ += now_seconds() - start_;
  }
  ScopedSeconds(const ScopedSeconds&) = delete;
  ScopedSeconds& operator=(const ScopedSeconds&) = delete;

 private:
  double* counter_;
  double start_;
};

}  // namespace ringsplat
