#include "model/charge.hpp"

// A function of SimGrid's. Weak: null when the program is linked with another MPI.
extern "C" void smpi_execute_benched(double seconds) __attribute__((weak));

namespace ringsplat {

bool simulated() { return smpi_execute_benched != nullptr; }

void charge(double seconds) {
  if (simulated() && seconds > 0) smpi_execute_benched(seconds);
}

bool Debt::pay() {
  if (!(owed_ > 0)) return false;
  // The last piece includes the remainder, so that rounding leaves no sliver.
  const double now = owed_ < 1.5 * piece_ ? owed_ : piece_;
  charge(now);
  owed_ -= now;
  return true;
}

}  // namespace ringsplat
