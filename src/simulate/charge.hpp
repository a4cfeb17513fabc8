#pragma once
#include <cmath>
#include <ctime>

#include "base/log.hpp"
#include "net/launcher.hpp"

// A function of SimGrid's, as in net/launcher.hpp.
extern "C" int smpi_nanosleep(const timespec* time, timespec* left) __attribute__((weak));

namespace ringsplat {

/// On which rank, if any, computing takes how many times as long as on others. Ranks share the variables.
inline int slow_rank = -1;
inline double slowness = 1;

/// Advances this rank's simulated clock by so many seconds of computing; does nothing outside of a
/// simulation.
inline void charge(double seconds) {
  if (simulated() && seconds > 0)
    smpi_execute_benched((slow_rank >= 0 && log_rank_in_use() == slow_rank ? slowness : 1) * seconds);
}

/// Lets so many seconds of the simulated clock pass without computing; does nothing outside of a simulation.
inline void sleep_simulated(double seconds) {
  if (smpi_nanosleep == nullptr || !(seconds > 0)) return;
  const double whole = std::floor(seconds);
  const timespec time{time_t(whole), long(1e9 * (seconds - whole))};
  smpi_nanosleep(&time, nullptr);
}

/// Simulated time owed for work that was done at once. It is paid in pieces, so that the rank can handle
/// messages in between.
class Debt {
 public:
  /// `piece`: seconds charged at once, above 0.
  explicit Debt(double piece) : piece_(piece) {}
  void owe(double seconds) { owed_ += seconds; }
  /// Charges one piece; false when nothing is owed.
  bool pay() {
    if (!(owed_ > 0)) return false;
    // The last piece includes the remainder, so that rounding leaves no sliver.
    const double now = owed_ < 1.5 * piece_ ? owed_ : piece_;
    charge(now);
    owed_ -= now;
    return true;
  }

 private:
  double piece_, owed_ = 0;
};

}  // namespace ringsplat
