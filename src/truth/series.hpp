#pragma once
#include <algorithm>
#include <array>

#include "truth/ball.hpp"

namespace ringsplat::truth {

/// Taylor's coefficients 0 to N of a function about a place, or about every place of an interval at once. The
/// recurrences are those of Moore (1966, chapter 11).
template <int N>
struct Series {
  std::array<Ball, N + 1> c{};
  Ball& operator[](int k) { return c[std::size_t(k)]; }
  const Ball& operator[](int k) const { return c[std::size_t(k)]; }

  friend Series operator*(Series a, const Ball& factor) {
    for (Ball& x : a.c) x = x * factor;
    return a;
  }
  friend Series operator*(const Series& a, const Series& b) {
    Series product;
    for (int k = 0; k <= N; ++k) product[k] = convolved(a, b, k, 0, k);
    return product;
  }
  /// The sum of a[j] b[k - j].
  friend Ball convolved(const Series& a, const Series& b, int k, int first, int last) {
    Ball sum;
    for (int j = first; j <= last; ++j) sum = with_product(sum, a[j], b[k - j]);
    return sum;
  }
};

/// 1/k.
constexpr Ball one_over(int k) { return {1.0 / k, 0x1p-52}; }

/// a[0] is above zero.
template <int N>
Series<N> log_of(const Series<N>& a) {
  Series<N> l;
  l[0] = log_of(interval_of(a[0]));
  const Ball inverse = inverse_of(a[0]);
  Series<N> slope;  // k · l[k]
  for (int k = 1; k <= N; ++k) {
    slope[k] = (double(k) * a[k] - convolved(slope, a, k, 1, k - 1)) * inverse;
    l[k] = slope[k] * one_over(k);
  }
  return l;
}

/// a[0] is above zero.
template <int N>
Series<N> power(const Series<N>& a, double exponent) {
  Series<N> p;
  p[0] = power(interval_of(a[0]), exponent);
  const Ball inverse = inverse_of(a[0]);
  for (int k = 1; k <= N; ++k) {
    Ball sum;
    for (int j = 1; j <= k; ++j)
      sum = with_product(sum, (Ball(exponent) * double(j) - double(k - j)) * a[j], p[k - j]);
    p[k] = sum * inverse * one_over(k);
  }
  return p;
}

/// What a density emits as seen from where the series was made, before which its integral is `start`: density
/// · exp(−integral), whose own integral is −exp(−integral).
template <int N>
Series<N> seen_through_itself(const Series<N>& density, const Ball& start) {
  Series<N> seen, left;
  left[0] = exp_of(interval_of(-start));
  for (int k = 0; k <= N; ++k) {
    seen[k] = convolved(density, left, k, 0, k);
    if (k < N) left[k + 1] = -seen[k] * one_over(k + 1);
  }
  return seen;
}

/// A polynomial of degree three of the place on a ray, over [0, 1].
using Polynomial = std::array<Ball, 4>;

inline bool is_level(const Polynomial& p) {
  return std::all_of(p.begin() + 1, p.end(), [](const Ball& c) { return c.middle == 0 && c.radius == 0; });
}

/// The same of places that count from `place`. What is level stays so without rounding.
inline Polynomial about(const Polynomial& p, const Ball& place) {
  Polynomial q = p;
  if (is_level(p)) return q;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 3; k-- > i;) q[k] = with_product(q[k], place, q[k + 1]);
  return q;
}

/// The polynomial's series about 0, or about all places within `reach` of it.
template <int N>
Series<N> series_of(const Polynomial& p, double reach) {
  Series<N> s;
  if (reach == 0 || is_level(p)) {
    std::copy_n(p.begin(), std::min(N + 1, 4), s.c.begin());
    return s;
  }
  const double half = 0.5 * OutwardRounding::up(reach * reach);
  const Ball v(0, reach), square(half, half), cube(0, OutwardRounding::up(2 * half * reach));
  s[0] = with_product(with_product(with_product(p[0], p[1], v), p[2], square), p[3], cube);
  if constexpr (N >= 1) s[1] = with_product(with_product(p[1], p[2], 2.0 * v), p[3], 3.0 * square);
  if constexpr (N >= 2) s[2] = with_product(p[2], p[3], 3.0 * v);
  if constexpr (N >= 3) s[3] = p[3];
  return s;
}

}  // namespace ringsplat::truth
