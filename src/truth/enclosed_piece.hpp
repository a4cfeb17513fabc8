#pragma once
#include <algorithm>
#include <array>
#include <optional>

#include "truth/enclosed_curve.hpp"
#include "truth/enclosed_light.hpp"

namespace ringsplat::truth {

/// What a piece of a ray adds and lets through. Where its light is known as a mean alone, of `mean_of`,
/// colour is what follows from that.
struct EnclosedPiece {
  std::array<Interval, 3> colour{};
  Interval transmittance = 1;
  std::optional<std::array<Interval, 3>> mean_of = std::nullopt;

  double width() const {
    double most = truth::width(transmittance);
    for (const Interval& c : colour) most = std::max(most, truth::width(c));
    return most;
  }
};

/// One seen through another.
EnclosedPiece behind(const EnclosedPiece& front, const EnclosedPiece& back);

/// What of a cell decides the medium along a passage.
struct CellMedium {
  Polynomial value;
  std::optional<EnclosedLight> light = std::nullopt;
  Interval length_of_passage = 0;
};

/// The piece [a, b] of a passage, in parts of it.
struct Part {
  Part(const Interval& length_of_passage, double a, double b)
      : middle(0.5 * Interval(a) + 0.5 * Interval(b)),
        half(0.5 * (Interval(b) - Interval(a))),
        passage_length(length_of_passage),
        length(2.0 * half * passage_length) {}
  double reach() const { return half.upper(); }
  Interval middle, half, passage_length, length;
};

/// Between which numbers all of a piece is.
struct Extremes {
  Interval value;
  EnclosedCurve::Channels of_curve;
  EnclosedLight::Bounds light{Interval(1), Interval(0), {true, false, 0, 1}};
  const Interval& opacity() const { return of_curve[EnclosedCurve::opacity]; }
  /// May be above 1, which is then shown as 1.
  Interval lit(std::size_t channel) const { return of_curve[channel] * light.scale + light.highlight; }
};

Extremes extremes_of(const EnclosedCurve& lines, const CellMedium& medium, const Part& part);

/// By extremes alone.
EnclosedPiece between(const Extremes& e, const Part& part);
/// By Taylor's series about the middle, with the last coefficient of the whole piece as remainder; nothing
/// where light or opacity have none.
std::optional<EnclosedPiece> expanded(const EnclosedCurve& lines, const CellMedium& medium, const Extremes& e,
                                      const Part& part);

}  // namespace ringsplat::truth
