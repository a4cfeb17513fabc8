#include <cmath>
#include <random>

#include "support/catch.hpp"
#include "truth/series.hpp"

using namespace ringsplat::truth;

namespace {

using Real = long double;

bool holds(const Interval& interval, Real exact) {
  return interval.lower() <= exact && exact <= interval.upper();
}

bool is_none(const Interval& x) { return !(x.lower() <= x.upper()); }

/// Members of two intervals, either of which may be a number, have zero inside, or be tiny.
struct Drawn {
  Interval a, b;
  double in_a, in_b;
};

Drawn draw(std::mt19937& random) {
  std::uniform_real_distribution<double> part(0, 1), about(-2, 2);
  const auto one = [&](Interval& interval) {
    const double scale = std::pow(10, 8 * about(random)), from = about(random) * scale;
    const double size = part(random) < 0.3 ? 0 : part(random) * scale;
    interval = {from, from + size};
    return std::min(from + part(random) * size, interval.upper());
  };
  Drawn drawn;
  drawn.in_a = one(drawn.a);
  drawn.in_b = one(drawn.b);
  return drawn;
}

}  // namespace

TEST_CASE("results of intervals hold the results of their members, and hardly more") {
  std::mt19937 random(7);
  std::size_t outside = 0, wide = 0;
  const auto see = [&](const Interval& result, Real exact) { outside += !holds(result, exact); };
  for (int trial = 0; trial < 100'000; ++trial) {
    const auto& [a, b, x, y] = draw(random);
    see(a + b, Real(x) + y);
    see(a - b, Real(x) - y);
    see(-a, -Real(x));
    see(a * b, Real(x) * y);
    see(a * y, Real(x) * y);
    see(x * b, Real(x) * y);
    see(abs(a), std::abs(Real(x)));
    see(square(a), Real(x) * x);
    see(hull(a, b), x);
    if (b.lower() > 0 || b.upper() < 0) see(a / b, Real(x) / y);
    if (y != 0) see(a / y, Real(x) / y);
    const Interval product = Interval(x) * Interval(y);
    wide += width(product) > 1e-14 * std::abs(x * y);
    const Interval small = clamped(a, 1e-3, 20);
    const double in_small = std::clamp(x, 1e-3, 20.0);
    see(log_of(small), std::log(Real(in_small)));
    see(exp_of(small), std::exp(Real(in_small)));
    see(power(small, 2.5), std::pow(Real(in_small), Real(2.5)));
    see(power(small, -0.5), 1 / std::sqrt(Real(in_small)));
  }
  CHECK(outside == 0);
  CHECK(wide == 0);
}

TEST_CASE("what is no number stays so, and what may be divided by zero is anything") {
  const Interval none(2, 1), zero(0), one(1);
  CHECK(is_none(none));
  for (const Interval& x : {none + one, one - none, none * zero, zero * none, none / 3.0}) CHECK(is_none(x));
  CHECK(std::isinf(width(one / Interval(-1, 1))));
  CHECK(holds(hull(Interval::empty(), one), 1));
  CHECK(width(hull(Interval::empty(), one)) < 1e-15);
}

TEST_CASE("results of balls hold the results of their members, and hardly more") {
  std::mt19937 random(7);
  std::size_t outside = 0, wide = 0;
  const auto see = [&](const Interval& result, Real exact) { outside += !holds(result, exact); };
  for (int trial = 0; trial < 100'000; ++trial) {
    const auto& [a, b, x, y] = draw(random);
    const Ball p = a, q = b;
    see(p, x);
    see(-p, -Real(x));
    see(p + q, Real(x) + y);
    see(p - q, Real(x) - y);
    see(p * q, Real(x) * y);
    see(p * y, Real(x) * y);
    see(with_product(q, p, q), Real(y) + Real(x) * y);
    if (b.lower() > 0 || b.upper() < 0) see(inverse_of(q), 1 / Real(y));
    wide += (Ball(x) * y).radius > 1e-14 * std::abs(x * y);
    wide += width(interval_of(p * q)) > 1.5 * width(a * b) + 1e-13 * largest_of(a * b);
  }
  CHECK(outside == 0);
  CHECK(wide == 0);
  CHECK(interval_of(Ball(0.1)).lower() == interval_of(Ball(0.1)).upper());
  CHECK(is_none(Ball(1) * Interval(1, INFINITY)));
  for (int k = 1; k < 8; ++k) CHECK(holds(one_over(k), Real(1) / k));
}

TEST_CASE("series hold those of what they stand for") {
  // Of 1/2 + x/4: ln, a power, and what it emits as seen through itself from x = 0.
  constexpr int terms = 4;
  Series<terms> line;
  line[0] = 0.5;
  line[1] = 0.25;
  const Series<terms> log = log_of(line), root = power(line, 0.5), seen = seen_through_itself(line, 0.0);
  const auto at = [](const Series<terms>& s, Real x) {
    Real sum = 0;
    for (int k = terms; k >= 0; --k) sum = sum * x + Real(s[k].middle);
    return sum;
  };
  for (const Real x : {-0.01L, 0.01L}) {
    const Real value = 0.5L + 0.25L * x, depth = 0.5L * x + 0.125L * x * x;
    CHECK(double(std::abs(at(log, x) - std::log(value))) < 1e-10);
    CHECK(double(std::abs(at(root, x) - std::sqrt(value))) < 1e-10);
    CHECK(double(std::abs(at(seen, x) - value * std::exp(-depth))) < 1e-10);
  }
  for (int k = 0; k <= terms; ++k) CHECK(seen[k].radius < 1e-14);
}
