#pragma once
#include "truth/interval.hpp"

namespace ringsplat::truth {

/// A set of real numbers about a double (Rump 1999). Sums and products need no comparisons, so that they take
/// less time than an interval's; of two wide factors a product is up to half wider. Of what is no number
/// nothing is known.
struct Ball {
  double middle = 0, radius = 0;

  constexpr Ball() = default;
  constexpr Ball(double exact) : middle(exact) {}
  constexpr Ball(double about, double by) : middle(about), radius(by) {}
  Ball(const Interval& x) : middle(median(x)) {
    if (x.lower() != x.upper())
      radius = OutwardRounding::up(std::max(x.upper() - middle, middle - x.lower()));
  }
  operator Interval() const {
    if (radius == 0) return middle;
    return {OutwardRounding::down(middle - radius), OutwardRounding::up(middle + radius)};
  }

  friend Ball operator-(const Ball& a) { return {-a.middle, a.radius}; }
  friend Ball operator+(const Ball& a, const Ball& b) {
    const double sum = a.middle + b.middle;
    return rounded(sum, a.radius + b.radius, std::abs(sum));
  }
  friend Ball operator-(const Ball& a, const Ball& b) { return a + -b; }
  friend Ball operator*(const Ball& a, const Ball& b) { return with_product({}, a, b); }
  /// x + a · b.
  friend Ball with_product(const Ball& x, const Ball& a, const Ball& b) {
    const double product = a.middle * b.middle, sum = x.middle + product,
                 off = std::abs(a.middle) * b.radius + a.radius * (std::abs(b.middle) + b.radius);
    return rounded(sum, x.radius + off, std::abs(product) + std::abs(sum));
  }

 private:
  /// With twice the rounding of numbers whose sizes come to `size`, and more than that, by at most 2⁻⁵³ each
  /// time, of the five operations that `by` took.
  static Ball rounded(double about, double by, double size) {
    constexpr double five_operations = 0x1p-50;
    return {about, by + (by * five_operations + (size * OutwardRounding::unit + OutwardRounding::least))};
  }
};

inline Interval interval_of(const Ball& x) { return x; }
inline Ball inverse_of(const Ball& x) { return Interval(1) / interval_of(x); }

}  // namespace ringsplat::truth
