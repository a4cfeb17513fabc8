// The renderer's three roundings, each measured alone against size. measure_roundings prints the same for
// more sizes.
#include "roundings.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

TEST_CASE("the DDA's drift: pixels, against the row's length") {
  // Each position is a row start plus a product rounded once, so its error is that of two roundings, whatever
  // the row's length: 2⁻⁵² of the largest coordinate. A running sum, beside it, drifts with the length.
  for (const int width : {64, 512, 4096, 32768}) {
    const auto errors = drift_errors(width);
    CAPTURE(width);
    CHECK(errors.dda < drift_bound(width));
    CHECK(errors.running_sum < width * std::ldexp(2.0 * width, -53));
    if (width >= 512) CHECK(errors.running_sum > 10 * errors.dda);  // the measurement can see a drift
  }
}

TEST_CASE("the quadratic's cancellation: Q, against the distance of its origin and the kernel's size") {
  // From the splat's own anchor the terms are a few units at most, so Q is off by a few 2⁻²⁴ whatever the
  // picture's or the kernel's size. From a far origin they grow with the square of the distance over the
  // kernel's width, and cancel.
  for (const double scale : {1.0, 4.0, 32.0}) {
    for (const double far : {128.0, 1024.0, 16384.0}) {
      const auto errors = quadratic_errors(scale, far);
      CAPTURE(scale, far);
      CHECK(errors.anchored < quadratic_bound);
      CHECK(errors.absolute < 4 * std::ldexp(std::pow(far / (1.6 * scale) + 1, 2), -22));
      if (scale == 1.0 && far == 16384.0)
        CHECK(errors.absolute > 1);  // no digit is left, and the measurement sees it
    }
  }
}

TEST_CASE("the composite's rounding: levels, against the number of slices") {
  // Each slice rounds what is accumulated and the colour once: at most 2⁻²⁴ of them a slice, or n · 2⁻²⁴
  // after n (Higham 2002, section 4.2); sums of like sign rounded to nearest do far better.
  double before = 0;
  for (const int slices : {64, 512, 4096})
    for (const double opacity : {1e-7, 1e-4, 0.005, 0.3}) {
      const double error = composite_error(slices, opacity);
      CAPTURE(slices, opacity);
      CHECK(error < composite_bound(slices));
      before = std::max(before, error);
    }
  CHECK(before < 1.3e-4);
}
