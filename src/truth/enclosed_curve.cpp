#include "truth/enclosed_curve.hpp"

namespace ringsplat::truth {
namespace {

/// More than TransferCurve::at() errs: a line between two rounded numbers from 0 to 1, whose colours are
/// powers of rounded numbers.
constexpr double rounding = 8e-15;

std::array<double, EnclosedCurve::channels> at(const TransferCurve& curve, double value) {
  const auto [colour, opacity] = curve.at(value);
  return {colour.r, colour.g, colour.b, opacity};
}

/// The line through what the curve has at two values on it. Where both have the same it is level, without
/// rounding.
EnclosedCurve::Line line_through(const TransferCurve& curve, double a, double b) {
  EnclosedCurve::Line line{0.5 * a + 0.5 * b, {}, {}};
  const auto one = at(curve, a), other = at(curve, b);
  for (std::size_t c = 0; c < EnclosedCurve::channels; ++c) {
    line.y[c] = one[c];
    if (one[c] == other[c]) continue;
    const Interval from = one[c] + within(rounding), to = other[c] + within(rounding);
    line.slope[c] = (to - from) / (Interval(b) - Interval(a));
    line.y[c] = from + line.slope[c] * (Interval(line.middle) - Interval(a));
  }
  return line;
}

}  // namespace

EnclosedCurve::EnclosedCurve(const TransferCurve& curve) : knots_(curve.knots()) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto level = [&](double value, double middle) {
    Line line{middle, {}, {}};
    const auto found = at(curve, value);
    std::copy(found.begin(), found.end(), line.y.begin());
    lines_.push_back(line);
  };
  level(-infinity, knots_.front());
  for (std::size_t k = 0; k + 1 < knots_.size(); ++k)
    lines_.push_back(line_through(curve, std::lerp(knots_[k], knots_[k + 1], 0.25),
                                  std::lerp(knots_[k], knots_[k + 1], 0.75)));
  level(infinity, knots_.back());
}

std::size_t EnclosedCurve::line_of(double value) const {
  return std::size_t(std::upper_bound(knots_.begin(), knots_.end(), value) - knots_.begin());
}

template <class See>
void EnclosedCurve::for_lines(const Interval& value, const See& see) const {
  for (std::size_t k = line_of(value.lower()), last = line_of(value.upper()); k <= last; ++k)
    see(lines_[k], Interval(k == 0 ? value.lower() : std::max(value.lower(), knots_[k - 1]),
                            k == knots_.size() ? value.upper() : std::min(value.upper(), knots_[k])));
}

EnclosedCurve::Channels EnclosedCurve::over(const Interval& value) const {
  Channels all;
  all.fill(Interval::empty());
  for_lines(value, [&](const Line& line, const Interval& part) {
    for (std::size_t c = 0; c < channels; ++c) all[c] = hull(all[c], clamped(line.at(c, part), 0, 1));
  });
  return all;
}

std::array<double, EnclosedCurve::channels> EnclosedCurve::off_line(std::size_t k,
                                                                    const Interval& value) const {
  std::array<double, channels> most{};
  for_lines(value, [&](const Line& line, const Interval& part) {
    if (&line == &lines_[k]) return;
    for (std::size_t c = 0; c < channels; ++c)
      most[c] = std::max(most[c], largest_of(line.at(c, part) - lines_[k].at(c, part)));
  });
  return most;
}

}  // namespace ringsplat::truth
