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
Series<N> square_of(const EnclosedNormal& normal, const Interval& place, double reach) {
  Series<N> squared;
  Interval positive = 0;
  for (const Polynomial& p : normal) {
    const Series<N> component = series_of<N>(p, place, reach);
    squared = squared + component * component;
    positive += square(component[0]);
  }
  squared[0] = positive;
  return squared;
}

/// What gradients leave of extinction (Gradients::left_at_edge) along a ray's way through a cell.
class EnclosedEdge {
 public:
  EnclosedEdge(const EdgeOpacity& edges, double unit, const EnclosedNormal& normal)
      : normal_(normal),
        from_(edges.from),
        ramp_(Interval(edges.to) - from_),
        scale_(Interval(1) / (unit * (1.0 + within(rounding)) * ramp_)) {}

  /// The share that is left.
  Interval over(const Interval& place, double reach) const {
    const Interval squared = square_of<0>(normal_, place, reach)[0],
                   root = power(max(squared, Interval(least_square)), 0.5),
                   steepness{squared.lower() > least_square ? root.lower() : 0, root.upper()};
    return clamped(steepness * scale_ - from_ / ramp_, 0, 1);
  }
  /// Where `all`, the share of the piece, is on the ramp.
  template <int N>
  Series<N> series(const Interval& all, const Interval& place, double reach) const {
    Series<N> share = power(square_of<N>(normal_, place, reach), 0.5) * scale_;
    share[0] = intersect(share[0] - from_ / ramp_, all);
    return share;
  }

 private:
  static constexpr double rounding = 1e-14;  ///< of a unit
  EnclosedNormal normal_;
  Interval from_, ramp_, scale_;
};

/// Phong's reflection (truth::Phong) along a ray's way through a cell, whose normal is a polynomial of the
/// place.
class EnclosedLight {
 public:
  /// What is not decided along a piece has a bound.
  struct Kind {
    bool smooth = false;     ///< has a series
    bool highlight = false;  ///< the series has one
    double missing = 0;      ///< what the series leaves out, at most
    double side = 1;         ///< of the surface that is lit
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

  EnclosedLight(const PhongMaterial& material, const glm::dvec3& to_light, const glm::dvec3& to_viewer,
                const EnclosedNormal& normal)
      : material_(material), normal_(normal) {
    for (std::size_t k = 0; k < 4; ++k)
      for (int axis = 0; axis < 3; ++axis) {
        towards_light_[k] += normal[std::size_t(axis)][k] * component(to_light, axis);
        towards_viewer_[k] += normal[std::size_t(axis)][k] * component(to_viewer, axis);
      }
    for (int axis = 0; axis < 3; ++axis)
      light_to_viewer_ += component(to_light, axis) * component(to_viewer, axis);
  }

  /// Whatever the normal.
  static Bounds any(const PhongMaterial& m) {
    return {m.ambient + m.diffuse * Interval(0, 1), Interval(0, m.specular), {}};
  }
  /// Everywhere within `reach` of `place`.
  Bounds over(const Interval& place, double reach) const {
    const Interval squared = square_of<0>(normal_, place, reach)[0];
    Bounds all = any(material_);
    if (!(squared.lower() > least_square)) return all;
    const Interval inverse = power(squared, -0.5),
                   light = clamped(series_of<0>(towards_light_, place, reach)[0] * inverse, -1, 1),
                   viewer = clamped(series_of<0>(towards_viewer_, place, reach)[0] * inverse, -1, 1),
                   mirrored = clamped(2.0 * light * viewer - light_to_viewer_, -1, 1),
                   same_side = light * viewer;
    all.scale = material_.ambient + material_.diffuse * abs(light);
    const bool dark = mirrored.upper() <= 0 || same_side.upper() <= 0,
               bright = mirrored.lower() > 0 && same_side.lower() > 0;
    const double most =
        dark ? 0 : (material_.specular * power(Interval(mirrored.upper()), material_.exponent)).upper();
    all.highlight = bright ? material_.specular * power(mirrored, material_.exponent) : Interval(0, most);
    constexpr double too_small_to_show = 1e-5;
    all.kind = {!(light.lower() < 0 && light.upper() > 0), bright && most > too_small_to_show, 0,
                light.lower() < 0 ? -1.0 : 1.0, mirrored};
    if (!all.kind.highlight) all.kind.missing = most;
    return all;
  }

  /// Of a kind that has a series.
  template <int N>
  Light<N> series(const Kind& kind, const Interval& place, double reach) const {
    const Series<N> inverse = power(square_of<N>(normal_, place, reach), -0.5),
                    light = series_of<N>(towards_light_, place, reach) * inverse;
    Light<N> result{light * Interval(kind.side * material_.diffuse), {}};
    result.scale[0] += material_.ambient;
    if (!kind.highlight) return result;
    Series<N> mirrored = light * (series_of<N>(towards_viewer_, place, reach) * inverse) * Interval(2.0);
    mirrored[0] = intersect(mirrored[0] - light_to_viewer_, kind.mirrored);
    result.highlight = power(mirrored, material_.exponent) * Interval(material_.specular);
    return result;
  }

 private:
  /// Of a direction of unit length up to rounding.
  static Interval component(const glm::dvec3& direction, int axis) {
    constexpr double rounding = 1e-14;
    return direction[axis] + within(rounding);
  }

  const PhongMaterial& material_;
  EnclosedNormal normal_;
  Polynomial towards_light_{}, towards_viewer_{};
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
  std::optional<EnclosedLight> light = std::nullopt;
  Interval length_of_passage = 0;
  glm::dvec4 tint{0.0};
  std::optional<EnclosedEdge> edge = std::nullopt;
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
  Interval share = 1;  ///< of extinction that gradients leave
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
