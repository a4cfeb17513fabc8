#include "simulate/charge.hpp"

#include <cmath>
#include <ctime>

// Functions of SimGrid's. Weak: null when the program is linked with another MPI.
extern "C" void smpi_execute_benched(double seconds) __attribute__((weak));
extern "C" int smpi_nanosleep(const timespec* time, timespec* left) __attribute__((weak));

namespace ringsplat {

void charge(double seconds) {
  if (smpi_execute_benched != nullptr && seconds > 0) smpi_execute_benched(seconds);
}

void sleep_simulated(double seconds) {
  if (smpi_nanosleep == nullptr || !(seconds > 0)) return;
  const double whole = std::floor(seconds);
  const timespec time{time_t(whole), long(1e9 * (seconds - whole))};
  smpi_nanosleep(&time, nullptr);
}

}  // namespace ringsplat
