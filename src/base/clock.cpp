#include "base/clock.hpp"

#include <chrono>

namespace ringsplat {
namespace {

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double (*clock_in_use)() = steady_seconds;

}  // namespace

double now_seconds() { return clock_in_use(); }

void set_clock(double (*clock)()) { clock_in_use = clock; }

}  // namespace ringsplat
