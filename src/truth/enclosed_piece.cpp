#include "truth/enclosed_piece.hpp"

#include "truth/ray.hpp"

namespace ringsplat::truth {
namespace {

/// Extinction of opacity that a unit length has; below 1.
Interval extinction_of(const Interval& opacity) { return -log_of(1.0 - opacity); }

/// A mean colour and one behind it that shows as far as `transmittance` says: all between its ends' results.
Interval mixture(const Interval& colour, const Interval& back, const Interval& transmittance) {
  const auto at = [&](double part) {
    return Interval(
        (Interval(colour.lower()) * (1.0 - Interval(part)) + back.lower() * Interval(part)).lower(),
        (Interval(colour.upper()) * (1.0 - Interval(part)) + back.upper() * Interval(part)).upper());
  };
  return clamped(hull(at(transmittance.lower()), at(transmittance.upper())), 0, 1);
}

/// The highest order of a series, whose coefficient is taken of the whole piece.
constexpr int order = 4;

/// Densities along a piece, of the ray's part in the cell, as series; those of light as seen from the piece's
/// middle.
template <int N>
struct Densities {
  Series<N> depth;
  Series<N> white, lit, change, highlight;  ///< of colour 1, of the line's colour at a value as it is lit, of
                                            ///< the line's slope from there, and beside these
};

/// `middle`: the value about which the line is taken.
template <int N>
Densities<N> densities(const CellMedium& medium, const Extremes& e, const EnclosedCurve::Line& line,
                       double middle, const Part& part, double reach) {
  Series<N> beyond = series_of<N>(medium.value, reach);
  beyond[0] = beyond[0] - middle;
  Series<N> clear = beyond * -line.slope[EnclosedCurve::opacity];
  clear[0] = clear[0] + (1.0 - line.at(EnclosedCurve::opacity, middle));
  Densities<N> made;
  made.depth = log_of(clear) * -part.passage_length;
  if (e.share.lower() < 1) made.depth = made.depth * medium.edge->series<N>(e.share, medium.normal, reach);
  made.white = seen_through_itself(made.depth, made.depth[0] * Ball(0, reach));
  made.lit = made.white;
  if (medium.light) {
    const auto light = medium.light->series<N>(e.light.kind, medium.normal, reach);
    made.lit = light.scale * made.white;
    if (e.light.kind.highlight) made.highlight = light.highlight * made.white;
  }
  made.change = beyond * made.lit;
  return made;
}

/// Adds what the line and the light leave out.
void widen(EnclosedPiece& piece, const Extremes& e, const std::array<double, EnclosedCurve::channels>& off,
           double clear, const Part& part) {
  // Twice as much as the bounds of docs/certified.md, lemmas 6 and 7, so that doubles will do.
  const double depth = 2 * off[EnclosedCurve::opacity] / clear * part.length.upper(),
               all = extinction(e.opacity().upper()) * part.length.upper() + depth;
  piece.transmittance = clamped(piece.transmittance * exp_of(within(depth)), 0, 1);
  for (std::size_t c = 0; c < 3; ++c) {
    const double colour = off[c] * e.light.scale.upper();
    const double by =
        2 * colour * (1 - piece.transmittance.lower()) + 2 * depth + 2 * all * std::expm1(depth);
    // What the series' light has too little, and too much where colours end at 1.
    const Interval beside{e.lit(c).lower() < 1 ? std::min(0.0, 1 - e.lit(c).upper()) : 0,
                          e.light.kind.missing};
    piece.colour[c] = clamped(piece.colour[c] + within(by) + beside * (1.0 - piece.transmittance), 0, 1);
  }
}

/// Integrals of powers from 0 to `end`.
using Powers = std::array<Ball, order + 1>;
Powers powers_to(const Ball& end) {
  Powers all;
  Ball power = end;
  for (int k = 0; k <= order; ++k, power = power * end) all[std::size_t(k)] = power * one_over(k + 1);
  return all;
}

/// Of a density from 0 on, or of every `step`-th term. `rest`: the coefficient of all of the piece.
Ball integral(const Powers& powers, const Series<order - 1>& density, const Ball& rest, int step = 1) {
  Ball sum = powers[order] * rest;
  for (int k = 0; k < order; k += step) sum = with_product(sum, powers[std::size_t(k)], density[k]);
  return sum;
}

}  // namespace

EnclosedPiece behind(const EnclosedPiece& front, const EnclosedPiece& back) {
  EnclosedPiece both;
  for (std::size_t c = 0; c < 3; ++c)
    both.colour[c] = front.mean_of ? mixture((*front.mean_of)[c], back.colour[c], front.transmittance)
                                   : clamped(front.colour[c] + front.transmittance * back.colour[c], 0, 1);
  both.transmittance = clamped(front.transmittance * back.transmittance, 0, 1);
  return both;
}

CellMedium about(const CellMedium& medium, const Ball& place) {
  CellMedium moved = medium;
  moved.value = about(medium.value, place);
  for (Polynomial& p : moved.normal) p = about(p, place);
  return moved;
}

Extremes extremes_of(const EnclosedCurve& lines, const CellMedium& medium, const Part& part) {
  Extremes e;
  e.value = interval_of(series_of<0>(medium.value, part.reach())[0]);
  e.of_curve = lines.over(e.value);
  for (std::size_t c = 0; c < EnclosedCurve::opacity; ++c)
    e.of_curve[c] = tinted(e.of_curve[c], medium.tint, c);
  if (medium.light) e.light = medium.light->over(medium.normal, part.reach());
  if (medium.edge) e.share = medium.edge->over(medium.normal, part.reach());
  return e;
}

EnclosedPiece of_mean(const std::array<Interval, 3>& light, const Interval& transmittance) {
  EnclosedPiece piece{{}, transmittance, light};
  for (std::size_t c = 0; c < 3; ++c) piece.colour[c] = mixture(light[c], Interval(0), transmittance);
  return piece;
}

EnclosedPiece between(const Extremes& e, const Part& part) {
  const Interval& opacity = e.opacity();
  const auto through = [&](double opaque, double share) {
    if (!(opaque > 0 && share > 0)) return Interval(1);
    if (opaque >= 1) return Interval(0);
    const Interval depth = extinction_of(Interval(opaque)) * part.length;
    return exp_of(-(share < 1 ? depth * share : depth));
  };
  return of_mean({clamped(e.lit(0), 0, 1), clamped(e.lit(1), 0, 1), clamped(e.lit(2), 0, 1)},
                 {through(opacity.upper(), e.share.upper()).lower(),
                  std::min(1.0, through(opacity.lower(), e.share.lower()).upper())});
}

std::optional<EnclosedPiece> expanded(const EnclosedCurve& lines, const CellMedium& medium, const Extremes& e,
                                      const Part& part) {
  constexpr double most_opacity = 0.9999;
  if (!e.light.kind.smooth || !(e.opacity().upper() < most_opacity)) return std::nullopt;
  const bool on_ramp = e.share.lower() > 0 && e.share.upper() < 1;
  if (!on_ramp && e.share.lower() < 1) return std::nullopt;
  const std::size_t on = lines.line_of(median(e.value));
  const EnclosedCurve::Line& line = lines.line(on);
  const auto off = lines.off_line(on, e.value);
  const double clear = 1 - e.opacity().upper() - off[EnclosedCurve::opacity];
  if (!(clear > 0) || !(line.at(EnclosedCurve::opacity, e.value).upper() < 1)) return std::nullopt;
  const double middle = median(e.value);
  const auto rest = densities<order>(medium, e, line, middle, part, part.reach());
  const auto exact = densities<order - 1>(medium, e, line, middle, part, 0);
  const Powers forward = powers_to(part.half), backward = powers_to(-part.half);
  const auto whole = [&](const Series<order - 1>& density, const Series<order>& everywhere) -> Interval {
    return 2.0 * integral(forward, density, everywhere[order], 2);
  };
  EnclosedPiece piece;
  piece.transmittance = exp_of(-whole(exact.depth, rest.depth));
  const Interval before = exp_of(interval_of(integral(backward, exact.depth, rest.depth[order]))),
                 white = whole(exact.white, rest.white), lit = whole(exact.lit, rest.lit),
                 change = whole(exact.change, rest.change),
                 highlight = whole(exact.highlight, rest.highlight);
  for (std::size_t c = 0; c < 3; ++c) {
    const Interval colour = tinted(line.at(c, middle), medium.tint, c),
                   slope = line.slope[c] * (1.0 - Interval(medium.tint.w));
    piece.colour[c] = before * (e.lit(c).lower() >= 1 ? white : colour * lit + slope * change + highlight);
  }
  widen(piece, e, off, clear, part);
  return piece;
}

}  // namespace ringsplat::truth
