#pragma once

namespace ringsplat {

/// Seconds on a monotonic clock: the machine's, or the one that replaces it.
double now_seconds();

/// Replaces the clock of this process by a simulated one. Called before anything is timed; `clock` stays
/// valid.
void set_clock(double (*clock)());

/// Adds the seconds of its lifetime to a counter.
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

/// The same for a counter that may be null; then it does not even read the clock.
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
