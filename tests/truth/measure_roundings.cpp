// Prints the renderer's three roundings against size as CSV, for scripts/study accuracy: for each its
// errors, those of the alternative, and the tests' bound.
#include <fmt/format.h>

#include "roundings.hpp"

using namespace ringsplat::test;

namespace {

void print(const char* rounding, const std::string& line, double size, double error) {
  fmt::print("{},{},{},{:.6g}\n", rounding, line, size, error);
}

}  // namespace

int main() {
  fmt::print("rounding,line,size,error\n");
  for (int width = 16; width <= 65536; width *= 2) {
    const auto errors = drift_errors(width);
    print("drift", "as drawn", width, errors.dda);
    print("drift", "a running sum", width, errors.running_sum);
    print("drift", "bound", width, drift_bound(width));
  }
  for (double far = 16; far <= 16384; far *= 2) {
    const auto errors = quadratic_errors(1, far);
    print("quadratic", "as drawn", far, errors.anchored);
    print("quadratic", "from a fixed origin", far, errors.absolute);
    print("quadratic", "bound", far, quadratic_bound);
  }
  for (double scale = 1; scale <= 512; scale *= 2)
    print("kernel", "as drawn", scale, quadratic_errors(scale, 0).anchored);
  for (double scale = 1; scale <= 512; scale *= 2) print("kernel", "bound", scale, quadratic_bound);
  for (const double opacity : {1e-7, 1e-4, 0.005, 0.3})
    for (int slices = 16; slices <= 16384; slices *= 2)
      print("composite", fmt::format("opacity {}", opacity), slices, composite_error(slices, opacity));
  for (int slices = 16; slices <= 16384; slices *= 2)
    print("composite", "bound", slices, composite_bound(slices));
}
