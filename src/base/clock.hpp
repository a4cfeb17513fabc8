#pragma once
#include <algorithm>
#include <chrono>
#include <utility>

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

/// Seconds since `last`, which becomes now, for those who look again and again whether something moves. At
/// most `longest`, more than a look takes: a process that was suspended meanwhile, as by a batch system, has
/// not waited.
inline double seconds_awake(double& last, double longest) {
  const double now = now_seconds();
  return std::min(now - std::exchange(last, now), longest);
}

}  // namespace ringsplat
