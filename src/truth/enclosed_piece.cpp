#include "truth/enclosed_piece.hpp"

#include "truth/ray.hpp"

namespace ringsplat::truth {
namespace {

/// Extinction of opacity that a unit length has; below 1.
template <class T>
T extinction_of(const T& opacity) {
  return log_of(one_minus(opacity)) * Interval(-1);
}

/// A mean colour and one behind it that shows as far as `transmittance` says: all between its ends' results.
Interval mixture(const Interval& colour, const Interval& back, const Interval& transmittance) {
  const auto at = [&](double part) {
    return Interval(
        (Interval(colour.lower()) * (1.0 - Interval(part)) + back.lower() * Interval(part)).lower(),
        (Interval(colour.upper()) * (1.0 - Interval(part)) + back.upper() * Interval(part)).upper());
  };
  return clamped(hull(at(transmittance.lower()), at(transmittance.upper())), 0, 1);
}

/// Densities along a piece, of the ray's part in the cell, as series.
template <int N>
struct Densities {
  Series<N> depth;
  std::array<Series<N>, 3> emission;  ///< seen from the piece's middle
};

/// The highest order of a series, whose coefficient is taken of the whole piece.
constexpr int order = 4;

template <int N>
Densities<N> densities(const CellMedium& medium, const Extremes& e, const EnclosedCurve::Line& line,
                       const Part& part, double reach) {
  const Series<N> value = series_of<N>(medium.value, part.middle, reach);
  const auto of_curve = [&](std::size_t channel) {
    const bool is_tinted = channel != EnclosedCurve::opacity && medium.tint.w != 0;
    Series<N> s = value * line.slope[channel];
    if (is_tinted) s = s * (1.0 - Interval(medium.tint.w));
    s[0] = line.at(channel, value[0]);
    if (is_tinted) s[0] = tinted(s[0], medium.tint, channel);
    return s;
  };
  Densities<N> made;
  made.depth = extinction_of(of_curve(EnclosedCurve::opacity)) * part.passage_length;
  if (e.share.lower() < 1) made.depth = made.depth * medium.edge->series<N>(e.share, part.middle, reach);
  const Series<N> seen = seen_through_itself(made.depth, made.depth[0] * within(reach));
  EnclosedLight::Light<N> light;
  if (medium.light) light = medium.light->series<N>(e.light.kind, part.middle, reach);
  for (std::size_t c = 0; c < 3; ++c) {
    if (e.lit(c).lower() >= 1)
      made.emission[c] = seen;
    else if (medium.light)
      made.emission[c] = (of_curve(c) * light.scale + light.highlight) * seen;
    else
      made.emission[c] = of_curve(c) * seen;
  }
  return made;
}

/// Adds what the line and the light leave out.
void widen(EnclosedPiece& piece, const Extremes& e, const std::array<double, EnclosedCurve::channels>& off,
           double clear, const Part& part) {
  // Twice as much as the bounds of docs/certified.md, lemma 6, so that doubles will do.
  const double depth = 2 * off[EnclosedCurve::opacity] / clear * part.length.upper(),
               all = extinction(e.opacity().upper()) * part.length.upper() + depth;
  piece.transmittance = clamped(piece.transmittance * exp_of(within(depth)), 0, 1);
  for (std::size_t c = 0; c < 3; ++c) {
    const double colour = off[c] * e.light.scale.upper() + e.light.kind.missing;
    const double by =
        2 * colour * (1 - piece.transmittance.lower()) + 2 * depth + 2 * all * std::expm1(depth);
    piece.colour[c] = clamped(piece.colour[c] + within(by), 0, 1);
  }
}

/// Integrals of powers from 0 to half.
using Powers = std::array<Interval, order + 1>;

Powers powers_of(const Interval& half) {
  Powers all;
  Interval power = half;
  for (int k = 0; k <= order; ++k, power *= half) all[std::size_t(k)] = power / double(k + 1);
  return all;
}

/// Of a density from −half to half.
Interval both_sides(const Series<order - 1>& density, const Interval& rest, const Powers& powers) {
  Interval sum = powers[order] * rest;
  for (int k = 0; k < order; k += 2) sum += powers[std::size_t(k)] * density[k];
  return 2.0 * sum;
}
/// Of a density from −half to 0.
Interval front_side(const Series<order - 1>& density, const Interval& rest, const Powers& powers) {
  Interval sum = powers[order] * rest;
  for (int k = 0; k < order; ++k) {
    const Interval term = powers[std::size_t(k)] * density[k];
    sum += k % 2 == 0 ? term : -term;
  }
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

Extremes extremes_of(const EnclosedCurve& lines, const CellMedium& medium, const Part& part) {
  Extremes e;
  e.value = series_of<0>(medium.value, part.middle, part.reach())[0];
  e.of_curve = lines.over(e.value);
  for (std::size_t c = 0; c < EnclosedCurve::opacity; ++c)
    e.of_curve[c] = tinted(e.of_curve[c], medium.tint, c);
  if (medium.light) e.light = medium.light->over(part.middle, part.reach());
  if (medium.edge) e.share = medium.edge->over(part.middle, part.reach());
  return e;
}

EnclosedPiece between(const Extremes& e, const Part& part) {
  const Interval& opacity = e.opacity();
  EnclosedPiece piece;
  const auto through = [&](double opaque, double share) {
    if (!(opaque > 0 && share > 0)) return Interval(1);
    if (opaque >= 1) return Interval(0);
    const Interval depth = extinction_of(Interval(opaque)) * part.length;
    return exp_of(-(share < 1 ? depth * share : depth));
  };
  piece.transmittance = {through(opacity.upper(), e.share.upper()).lower(),
                         std::min(1.0, through(opacity.lower(), e.share.lower()).upper())};
  piece.mean_of.emplace();
  for (std::size_t c = 0; c < 3; ++c) {
    (*piece.mean_of)[c] = clamped(e.lit(c), 0, 1);
    piece.colour[c] = mixture((*piece.mean_of)[c], Interval(0), piece.transmittance);
  }
  return piece;
}

std::optional<EnclosedPiece> expanded(const EnclosedCurve& lines, const CellMedium& medium, const Extremes& e,
                                      const Part& part) {
  constexpr double most_opacity = 0.9999;
  if (!e.light.kind.smooth || !(e.opacity().upper() < most_opacity)) return std::nullopt;
  const bool on_ramp = e.share.lower() > 0 && e.share.upper() < 1;
  if (!on_ramp && e.share.lower() < 1) return std::nullopt;
  for (std::size_t c = 0; c < 3; ++c)
    if (e.lit(c).lower() < 1 && e.lit(c).upper() > 1) return std::nullopt;
  const std::size_t on = lines.line_of(median(e.value));
  const EnclosedCurve::Line& line = lines.line(on);
  const auto off = lines.off_line(on, e.value);
  const double clear = 1 - e.opacity().upper() - off[EnclosedCurve::opacity];
  if (!(clear > 0) || !(line.at(EnclosedCurve::opacity, e.value).upper() < 1)) return std::nullopt;
  const auto rest = densities<order>(medium, e, line, part, part.reach());
  const auto exact = densities<order - 1>(medium, e, line, part, 0);
  const Powers powers = powers_of(part.half);
  EnclosedPiece piece;
  piece.transmittance = exp_of(-both_sides(exact.depth, rest.depth[order], powers));
  const Interval before = exp_of(-front_side(exact.depth, rest.depth[order], powers));
  for (std::size_t c = 0; c < 3; ++c)
    piece.colour[c] = before * both_sides(exact.emission[c], rest.emission[c][order], powers);
  widen(piece, e, off, clear, part);
  return piece;
}

}  // namespace ringsplat::truth
