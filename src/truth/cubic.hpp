#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ringsplat::truth {

/// The values along a ray's way through a cell: a cubic polynomial of s' = (s − enter) / (leave − enter),
/// p0 + p1 s' + p2 s'² + p3 s'³.
struct Cubic {
  std::array<double, 4> p;
  double at(double s) const { return p[0] + s * (p[1] + s * (p[2] + s * p[3])); }
};

/// The cubic that has the values of `at`, a function of s, at thirds of [enter, leave].
template <class At>
Cubic cubic_along(double enter, double leave, const At& at) {
  const auto y = [&](double part) { return at(std::lerp(enter, leave, part)); };
  const double y0 = y(0), y1 = y(1.0 / 3), y2 = y(2.0 / 3), y3 = y(1);
  return {{y0, (-11 * y0 + 18 * y1 - 9 * y2 + 2 * y3) / 2, (18 * y0 - 45 * y1 + 36 * y2 - 9 * y3) / 2,
           (-9 * y0 + 27 * y1 - 27 * y2 + 9 * y3) / 2}};
}

/// Places in [0, 1], ascending, both ends among them, between which the cubic is monotone.
inline std::vector<double> monotone_pieces(const Cubic& cubic) {
  const double a = 3 * cubic.p[3], b = 2 * cubic.p[2], c = cubic.p[1];
  std::vector<double> points{0.0, 1.0};
  const auto add = [&](double s) {
    if (s > 0 && s < 1) points.push_back(s);
  };
  const double discriminant = b * b - 4 * a * c;
  if (discriminant >= 0) {
    const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));  // no cancellation
    if (a != 0) add(q / a);
    if (q != 0) add(c / q);
  }
  std::sort(points.begin(), points.end());
  return points;
}

/// Where the cubic takes `value`. It is monotone on [a, b], and `value` lies between its ends.
inline double crossing_of(const Cubic& cubic, double value, double a, double b) {
  const bool rising = cubic.at(a) < cubic.at(b);
  for (int round = 0; round < 60 && a < b; ++round) {
    const double middle = 0.5 * (a + b);
    if (middle <= a || middle >= b) break;
    ((cubic.at(middle) < value) == rising ? a : b) = middle;
  }
  return 0.5 * (a + b);
}

/// Where the values cross knots of the transfer function, in (0, 1), ascending, with both ends.
inline std::vector<double> cuts_at_knots(const Cubic& cubic, const std::vector<double>& knots) {
  const std::vector<double> monotone = monotone_pieces(cubic);
  std::vector<double> cuts{0.0};
  for (std::size_t i = 0; i + 1 < monotone.size(); ++i) {
    const double a = monotone[i], b = monotone[i + 1];
    const auto [low, high] = std::minmax({cubic.at(a), cubic.at(b)});  // by value: references would dangle
    for (auto k = std::upper_bound(knots.begin(), knots.end(), low); k != knots.end() && *k < high; ++k)
      cuts.push_back(crossing_of(cubic, *k, a, b));
    cuts.push_back(b);
  }
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

}  // namespace ringsplat::truth
