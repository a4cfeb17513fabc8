#pragma once
#include <algorithm>
#include <boost/numeric/interval.hpp>
#include <cmath>

namespace ringsplat::truth {

/// Rounding of intervals' ends, for Boost.Interval. Each result is moved outward by as much as twice what
/// rounding to nearest may err, instead of changing the processor's mode of rounding, which compilers and
/// libraries do not expect.
struct OutwardRounding {
  using unprotected_rounding = OutwardRounding;
  static constexpr double unit = 0x1p-52, least = 0x1p-1000;
  static void init() {}
  static double down(double x) { return x - (std::abs(x) * unit + least); }
  static double up(double x) { return x + (std::abs(x) * unit + least); }
  static double conv_down(double x) { return x; }
  static double conv_up(double x) { return x; }
  static double add_down(double a, double b) { return down(a + b); }
  static double add_up(double a, double b) { return up(a + b); }
  static double sub_down(double a, double b) { return down(a - b); }
  static double sub_up(double a, double b) { return up(a - b); }
  static double mul_down(double a, double b) { return down(a * b); }
  static double mul_up(double a, double b) { return up(a * b); }
  static double div_down(double a, double b) { return down(a / b); }
  static double div_up(double a, double b) { return up(a / b); }
  static double median(double a, double b) { return 0.5 * (a + b); }
};

/// A set of real numbers between two doubles: each operation's result holds all results of the members
/// (Moore, Kearfott and Cloud 2009). Numbers beyond double's range and divisors with zero inside give bounds
/// that are infinite or no numbers.
using Interval = boost::numeric::interval<
    double, boost::numeric::interval_lib::policies<OutwardRounding,
                                                   boost::numeric::interval_lib::checking_base<double>>>;

using boost::numeric::median, boost::numeric::width;
/// An interval about 0.
inline Interval within(double radius) { return {-radius, radius}; }
inline double largest_of(const Interval& x) { return std::max(std::abs(x.lower()), std::abs(x.upper())); }
/// What of x lies in [low, high]; the nearer end where nothing does.
inline Interval clamped(const Interval& x, double low, double high) {
  return {std::clamp(x.lower(), low, high), std::clamp(x.upper(), low, high)};
}

/// glibc's functions err less than one unit in the last place ("Known Maximum Errors in Math Functions" of
/// its manual); these are moved outward by four.
inline Interval moved_outward(double low, double high) {
  constexpr double units = 4 * OutwardRounding::unit;
  return {OutwardRounding::down(low - std::abs(low) * units),
          OutwardRounding::up(high + std::abs(high) * units)};
}
inline Interval exp_of(const Interval& x) {
  const Interval e = moved_outward(std::exp(x.lower()), std::exp(x.upper()));
  return {std::max(0.0, e.lower()), e.upper()};
}
/// x is above zero.
inline Interval log_of(const Interval& x) { return moved_outward(std::log(x.lower()), std::log(x.upper())); }
inline Interval power(const Interval& x, double exponent) {
  if (exponent == -0.5) return moved_outward(1 / std::sqrt(x.upper()), 1 / std::sqrt(x.lower()));
  return exp_of(log_of(x) * exponent);
}

}  // namespace ringsplat::truth
