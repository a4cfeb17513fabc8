#pragma once
#include <array>

#include "truth/interval.hpp"

namespace ringsplat::truth {

/// Taylor's coefficients 0 to N of a function about a place, or about every place of an interval at once. The
/// recurrences are those of Moore (1966, chapter 11).
template <int N>
struct Series {
  std::array<Interval, N + 1> c{};
  Interval& operator[](int k) { return c[std::size_t(k)]; }
  const Interval& operator[](int k) const { return c[std::size_t(k)]; }

  friend Series operator+(Series a, const Series& b) {
    for (int k = 0; k <= N; ++k) a[k] += b[k];
    return a;
  }
  friend Series operator*(Series a, const Interval& factor) {
    for (Interval& x : a.c) x *= factor;
    return a;
  }
  friend Series operator*(const Series& a, const Series& b) {
    Series product;
    for (int k = 0; k <= N; ++k)
      for (int j = 0; j <= k; ++j) product[k] += a[j] * b[k - j];
    return product;
  }
};

inline Interval one_minus(const Interval& x) { return 1.0 - x; }
template <int N>
Series<N> one_minus(Series<N> a) {
  a = a * Interval(-1);
  a[0] += 1.0;
  return a;
}

/// a[0] is above zero.
template <int N>
Series<N> log_of(const Series<N>& a) {
  Series<N> l;
  l[0] = log_of(a[0]);
  const Interval inverse = Interval(1) / a[0];
  Series<N> slope;  // k · l[k]
  for (int k = 1; k <= N; ++k) {
    Interval sum = 0;
    for (int j = 1; j < k; ++j) sum += slope[j] * a[k - j];
    slope[k] = (double(k) * a[k] - sum) * inverse;
    l[k] = slope[k] / double(k);
  }
  return l;
}

/// a[0] is above zero.
template <int N>
Series<N> power(const Series<N>& a, double exponent) {
  Series<N> p;
  p[0] = power(a[0], exponent);
  const Interval inverse = Interval(1) / a[0];
  for (int k = 1; k <= N; ++k) {
    for (int j = 1; j <= k; ++j) p[k] += (Interval(exponent) * double(j) - double(k - j)) * a[j] * p[k - j];
    p[k] *= inverse / double(k);
  }
  return p;
}

/// What a density emits as seen from where the series was made, before which its integral is `start`: density
/// · exp(−integral), whose own integral is −exp(−integral).
template <int N>
Series<N> seen_through_itself(const Series<N>& density, const Interval& start) {
  Series<N> seen, left;
  left[0] = exp_of(-start);
  for (int k = 0; k <= N; ++k) {
    for (int j = 0; j <= k; ++j) seen[k] += density[j] * left[k - j];
    if (k < N) left[k + 1] = -seen[k] / double(k + 1);
  }
  return seen;
}

/// A polynomial of degree three of the place on a ray, over [0, 1].
using Polynomial = std::array<Interval, 4>;

/// The polynomial's series about `place`, or about all places within `reach` of it.
template <int N>
Series<N> series_of(const Polynomial& p, const Interval& place, double reach) {
  Polynomial q = p;  // about `place`
  for (int i = 0; i < 3; ++i)
    for (int k = 2; k >= i; --k)
      q[std::size_t(k)] = with_product(q[std::size_t(k)], place, q[std::size_t(k) + 1]);
  Series<N> s;
  if (reach == 0) {
    for (int k = 0; k <= std::min(N, 3); ++k) s[k] = q[std::size_t(k)];
    return s;
  }
  const Interval v = within(reach), square{0, OutwardRounding::up(reach * reach)}, cube = v * square;
  s[0] = with_product(with_product(with_product(q[0], q[1], v), q[2], square), q[3], cube);
  if constexpr (N >= 1) s[1] = q[1] + 2.0 * q[2] * v + 3.0 * q[3] * square;
  if constexpr (N >= 2) s[2] = q[2] + 3.0 * q[3] * v;
  if constexpr (N >= 3) s[3] = q[3];
  return s;
}

}  // namespace ringsplat::truth
