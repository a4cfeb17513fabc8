#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

namespace ringsplat::truth {

/// A set of real numbers between two doubles: each operation's result holds all results of the members
/// (Moore, Kearfott and Cloud 2009). Numbers beyond double's range and divisors with zero inside give bounds
/// that are infinite or no numbers.
///
/// Both ends are in one register, the lower one with its sign turned, so that both are rounded upward alike:
/// certified bounds are little but these operations. Each result is moved outward by at least twice what
/// rounding to nearest may err, as compilers and libraries do not expect another mode of rounding.
class Interval {
 public:
  static constexpr double unit = 0x1p-52, least = 0x1p-1000;

  Interval() : Interval(0.0) {}
  Interval(double x) : ends_{-x, x} {}
  Interval(double low, double high) : ends_{-low, high} {
    if (!(low <= high)) *this = Interval(std::numeric_limits<double>::quiet_NaN());
  }
  /// Of which hull() makes what it is joined with.
  static Interval empty() {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    return Interval(Ends{-infinity, -infinity});
  }
  double lower() const { return -ends_[0]; }
  double upper() const { return ends_[1]; }

  friend Interval operator-(const Interval& a) { return Interval(swapped(a.ends_)); }
  friend Interval operator+(const Interval& a, const Interval& b) { return outward(a.ends_ + b.ends_); }
  friend Interval operator-(const Interval& a, const Interval& b) {
    return outward(a.ends_ + swapped(b.ends_));
  }
  friend Interval operator*(const Interval& a, double b) {
    const Ends one = both(a.lower() * b), other = both(a.upper() * b);
    return largest(one, other, size(one) + size(other));
  }
  friend Interval operator*(double a, const Interval& b) { return b * a; }
  friend Interval operator*(const Interval& a, const Interval& b) {
    const Ends low = both(b.lower()), high = both(b.upper()), from{a.lower(), a.lower()},
               to{a.upper(), a.upper()}, p = from * low, q = from * high, r = to * low, s = to * high;
    return largest(larger(p, q), larger(r, s), size(p) + size(q) + size(r) + size(s));
  }
  friend Interval operator/(const Interval& a, double b) {
    return b > 0 ? outward(a.ends_ / b) : -outward(a.ends_ / -b);
  }
  friend Interval operator/(const Interval& a, const Interval& b) {
    if (!(b.lower() > 0 || b.upper() < 0)) return Interval(std::numeric_limits<double>::quiet_NaN());
    return a * outward(swapped(-1.0 / b.ends_));
  }
  Interval& operator+=(const Interval& b) { return *this = *this + b; }
  Interval& operator*=(const Interval& b) { return *this = *this * b; }

  friend Interval hull(const Interval& a, const Interval& b) { return Interval(larger(a.ends_, b.ends_)); }
  friend Interval intersect(const Interval& a, const Interval& b) {
    return {std::max(a.lower(), b.lower()), std::min(a.upper(), b.upper())};
  }
  static double up(double x) { return x + (std::abs(x) * unit + least); }
  static double down(double x) { return -up(-x); }

 private:
  using Ends = double __attribute__((vector_size(16)));
  using Bits = long long __attribute__((vector_size(16)));
  explicit Interval(const Ends& ends) : ends_(ends) {}

  static Ends both(double x) { return Ends{-x, x}; }
  static Ends swapped(const Ends& x) { return Ends{x[1], x[0]}; }
  static Ends larger(const Ends& a, const Ends& b) { return a > b ? a : b; }
  static Ends size(const Ends& x) {
    constexpr long long without_sign = std::numeric_limits<long long>::max();
    return Ends(Bits(x) & Bits{without_sign, without_sign});
  }
  static Interval outward(const Ends& x) { return Interval(x + (size(x) * unit + least)); }
  /// Of products: `sizes` is their sum, and no number where one of them is none.
  static Interval largest(const Ends& one, const Ends& other, const Ends& sizes) {
    return Interval(larger(one, other) + (sizes * unit + least));
  }

  Ends ends_;  ///< minus the lower one, the upper one
};

inline double width(const Interval& x) { return Interval::up(x.upper() - x.lower()); }
inline double median(const Interval& x) { return 0.5 * (x.lower() + x.upper()); }
/// An interval about 0.
inline Interval within(double radius) { return {-radius, radius}; }
inline double largest_of(const Interval& x) { return std::max(std::abs(x.lower()), std::abs(x.upper())); }
inline Interval abs(const Interval& x) {
  const bool has_zero = x.lower() <= 0 && x.upper() >= 0;
  return {has_zero ? 0 : std::min(std::abs(x.lower()), std::abs(x.upper())), largest_of(x)};
}
inline Interval square(const Interval& x) {
  const Interval size = abs(x), squared = size * size;
  return {std::max(0.0, squared.lower()), squared.upper()};
}
/// x + a · b, without rounding where a factor is zero.
inline Interval with_product(const Interval& x, const Interval& a, const Interval& b) {
  const auto is_zero = [](const Interval& factor) { return factor.lower() == 0 && factor.upper() == 0; };
  return is_zero(a) || is_zero(b) ? x : x + a * b;
}
/// What of x lies in [low, high]; the nearer end where nothing does.
inline Interval clamped(const Interval& x, double low, double high) {
  return {std::clamp(x.lower(), low, high), std::clamp(x.upper(), low, high)};
}

/// glibc's functions err less than one unit in the last place ("Known Maximum Errors in Math Functions" of
/// its manual); these are moved outward by four.
inline Interval moved_outward(double low, double high) {
  constexpr double units = 4 * Interval::unit;
  return {Interval::down(low - std::abs(low) * units), Interval::up(high + std::abs(high) * units)};
}
inline Interval exp_of(const Interval& x) {
  const Interval e = moved_outward(std::exp(x.lower()), std::exp(x.upper()));
  return {std::max(0.0, e.lower()), e.upper()};
}
/// x is above zero.
inline Interval log_of(const Interval& x) { return moved_outward(std::log(x.lower()), std::log(x.upper())); }
inline Interval power(const Interval& x, double exponent) { return exp_of(log_of(x) * exponent); }

}  // namespace ringsplat::truth
