#pragma once
#include <chrono>

namespace ringsplat {

/// Seconds on a clock that never goes back.
inline double now_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Adds the seconds it lives to a counter.
class ScopedSeconds {
 public:
  explicit ScopedSeconds(double& counter) : counter_(counter), start_(now_seconds()) {}
  ~ScopedSeconds() { counter_ += now_seconds() - start_; }
  ScopedSeconds(const ScopedSeconds&) = delete;
  ScopedSeconds& operator=(const ScopedSeconds&) = delete;

 private:
  double& counter_;
  double start_;
};

/// The same when there is a counter; without one it does not even read the clock.
class OptionalSeconds {
 public:
  explicit OptionalSeconds(double* counter) : counter_(counter), start_(counter ? now_seconds() : 0) {}
  ~OptionalSeconds() {
    if (counter_) *counter_ += now_seconds() - start_;
  }
  OptionalSeconds(const OptionalSeconds&) = delete;
  OptionalSeconds& operator=(const OptionalSeconds&) = delete;

 private:
  double* counter_;
  double start_;
};

}  // namespace ringsplat
