#pragma once
#include <algorithm>
#include <array>
#include <optional>

#include "truth/enclosed_curve.hpp"
#include "truth/series.hpp"

namespace ringsplat::truth {

/// A normal along a ray's way through a cell, as polynomials of the place.
using EnclosedNormal = std::array<Polynomial, 3>;
constexpr double least_square = 1e-250;  ///< of which a power is a number

template <int N>
Series<N> square_of(const EnclosedNormal& normal, double reach) {
  Series<N> squared;
  Interval positive = 0;
  for (const Polynomial& p : normal) {
    const Series<N> component = series_of<N>(p, reach);
    for (int k = 0; k <= N; ++k) squared[k] = squared[k] + convolved(component, component, k, 0, k);
    positive += square(interval_of(component[0]));
  }
  squared[0] = positive;
  return squared;
}

/// What gradients leave of extinction (Gradients::left_at_edge). `normal`: about a place, here and below.
class EnclosedEdge {
 public:
  EnclosedEdge(const EdgeOpacity& edges, double unit)
      : from_(edges.from),
        ramp_(Interval(edges.to) - from_),
        scale_(Interval(1) / (unit * (1.0 + within(rounding)) * ramp_)) {}

  /// The share that is left within `reach`.
  Interval over(const EnclosedNormal& normal, double reach) const {
    const Interval squared = square_of<0>(normal, reach)[0],
                   root = power(max(squared, Interval(least_square)), 0.5),
                   steepness{squared.lower() > least_square ? root.lower() : 0, root.upper()};
    return clamped(steepness * scale_ - from_ / ramp_, 0, 1);
  }
  /// Where `all`, the share of the piece, is on the ramp.
  template <int N>
  Series<N> series(const Interval& all, const EnclosedNormal& normal, double reach) const {
    Series<N> share = power(square_of<N>(normal, reach), 0.5) * scale_;
    share[0] = intersect(interval_of(share[0]) - from_ / ramp_, all);
    return share;
  }

 private:
  static constexpr double rounding = 1e-14;  ///< of a unit
  Interval from_, ramp_, scale_;
};

/// Phong's reflection (truth::Phong) along a ray.
class EnclosedLight {
 public:
  struct Kind {
    bool smooth = false;     ///< has a series: nowhere is the field level
    bool highlight = false;  ///< the series has one
    double missing = 0;      ///< what the series leaves out, at most
    double side = 1;         ///< of the surface that is lit, in the series
    Interval mirrored = 1;   ///< the mirrored light's part to the viewer
  };
  struct Bounds {
    Interval scale, highlight;
    Kind kind;
  };
  template <int N>
  struct Light {
    Series<N> scale, highlight;
  };

  EnclosedLight(const PhongMaterial& material, const glm::dvec3& to_light, const glm::dvec3& to_viewer)
      : material_(&material) {
    for (std::size_t k = 0; k < 3; ++k) {
      to_light_[k] = {to_light[int(k)], rounding};
      to_viewer_[k] = {to_viewer[int(k)], rounding};
      light_to_viewer_ += interval_of(to_light_[k] * to_viewer_[k]);
    }
  }

  /// Whatever the normal.
  static Bounds any(const PhongMaterial& m) {
    return {m.ambient + m.diffuse * Interval(0, 1), Interval(0, m.specular), {}};
  }
  /// Everywhere within `reach`.
  Bounds over(const EnclosedNormal& normal, double reach) const {
    const Interval squared = square_of<0>(normal, reach)[0];
    Bounds all = any(*material_);
    if (!(squared.lower() > least_square)) return all;
    const Interval inverse = power(squared, -0.5),
                   light = clamped(part_of<0>(normal, to_light_, reach)[0] * inverse, -1, 1),
                   viewer = clamped(part_of<0>(normal, to_viewer_, reach)[0] * inverse, -1, 1),
                   mirrored = clamped(2.0 * light * viewer - light_to_viewer_, -1, 1),
                   same_side = light * viewer;
    all.scale = material_->ambient + material_->diffuse * abs(light);
    const bool dark = mirrored.upper() <= 0 || same_side.upper() <= 0,
               bright = mirrored.lower() > 0 && same_side.lower() > 0;
    const double most =
        dark ? 0 : (material_->specular * power(Interval(mirrored.upper()), material_->exponent)).upper();
    all.highlight = bright ? material_->specular * power(mirrored, material_->exponent) : Interval(0, most);
    constexpr double too_small_to_show = 1e-5;
    const double side = median(light) < 0 ? -1 : 1,
                 other_side = std::max(0.0, side < 0 ? light.upper() : -light.lower());
    all.kind = {true, bright && most > too_small_to_show, 2 * material_->diffuse * other_side, side,
                mirrored};
    if (!all.kind.highlight) all.kind.missing += most;
    return all;
  }

  /// Of a kind that has a series.
  template <int N>
  Light<N> series(const Kind& kind, const EnclosedNormal& normal, double reach) const {
    const Series<N> inverse = power(square_of<N>(normal, reach), -0.5),
                    light = part_of<N>(normal, to_light_, reach) * inverse;
    Light<N> result{light * Ball(kind.side * material_->diffuse), {}};
    result.scale[0] = result.scale[0] + material_->ambient;
    if (!kind.highlight) return result;
    Series<N> mirrored = light * (part_of<N>(normal, to_viewer_, reach) * inverse) * Ball(2.0);
    mirrored[0] = intersect(interval_of(mirrored[0]) - light_to_viewer_, kind.mirrored);
    result.highlight = power(mirrored, material_->exponent) * Ball(material_->specular);
    return result;
  }

 private:
  using Direction = std::array<Ball, 3>;     ///< of unit length
  static constexpr double rounding = 1e-14;  ///< of its components
  /// A normal's part in a direction.
  template <int N>
  static Series<N> part_of(const EnclosedNormal& normal, const Direction& direction, double reach) {
    Polynomial part{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t k = 0; k < 4; ++k) part[k] = with_product(part[k], normal[axis][k], direction[axis]);
    return series_of<N>(part, reach);
  }

  const PhongMaterial* material_;
  Direction to_light_, to_viewer_;
  Interval light_to_viewer_ = 0;
};

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

/// One whose light is known as a mean.
EnclosedPiece of_mean(const std::array<Interval, 3>& light, const Interval& transmittance);
/// One seen through another.
EnclosedPiece behind(const EnclosedPiece& front, const EnclosedPiece& back);

/// A straight colour where a label's tint takes the place of its share (truth::Tints).
inline Interval tinted(const Interval& colour, const glm::dvec4& tint, std::size_t channel) {
  const Interval share = tint.w;
  return tint.w == 0 ? colour : (1.0 - share) * colour + share * tint[int(channel)];
}

/// What of a cell decides the medium along a passage.
struct CellMedium {
  Polynomial value;
  EnclosedNormal normal{};  ///< where light or edges need it
  std::optional<EnclosedLight> light = std::nullopt;
  Interval length_of_passage = 0;
  glm::dvec4 tint{0.0};
  std::optional<EnclosedEdge> edge = std::nullopt;
};
/// The same, of places that count from `place`.
CellMedium about(const CellMedium& medium, const Ball& place);

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
  Interval share = 1;  ///< of extinction that gradients leave
  const Interval& opacity() const { return of_curve[EnclosedCurve::opacity]; }
  /// May be above 1, which is then shown as 1.
  Interval lit(std::size_t channel) const { return of_curve[channel] * light.scale + light.highlight; }
};

/// `medium`: about the part's middle, here and below.
Extremes extremes_of(const EnclosedCurve& lines, const CellMedium& medium, const Part& part);

/// By extremes alone.
EnclosedPiece between(const Extremes& e, const Part& part);
/// By Taylor's series about the middle, with the last coefficient of the whole piece as remainder; nothing
/// where light or opacity have none.
std::optional<EnclosedPiece> expanded(const EnclosedCurve& lines, const CellMedium& medium, const Extremes& e,
                                      const Part& part);

}  // namespace ringsplat::truth
