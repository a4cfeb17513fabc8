// The steps that proved bounds are made of, each by itself: docs/certified.md, lemmas 3 to 8.
#include <random>

#include "pixel_bounds.hpp"
#include "support/catch.hpp"
#include "truth/cubic.hpp"
#include "truth/enclosed_piece.hpp"
#include "truth/passage.hpp"
#include "truth/quadrature.hpp"
#include "truth_support.hpp"

using namespace ringsplat;
using namespace ringsplat::test;
using truth::Interval, truth::Polynomial;

namespace {

bool holds(const Interval& interval, double exact, double tolerance = 0) {
  return interval.lower() <= exact + tolerance && exact - tolerance <= interval.upper();
}
bool holds(const truth::EnclosedPiece& piece, const truth::Piece& exact, double tolerance = 1e-10) {
  bool all = holds(piece.transmittance, exact.transmittance, tolerance);
  for (std::size_t c = 0; c < 3; ++c) all = all && holds(piece.colour[c], exact.colour[int(c)], tolerance);
  return all;
}

Polynomial exactly(const truth::Cubic& cubic) { return {cubic.p[0], cubic.p[1], cubic.p[2], cubic.p[3]}; }

/// Rises to 0.5, and from there more steeply by `bend`.
TransferFunction bent(double bend) {
  TransferFunction tf;
  tf.colours = {{0, {0.9, 0.2, 0.1}}, {1, {0.2, 0.8, 1}}};
  tf.opacities = {{0, 0.1}, {0.5, 0.3}, {1, 0.5 + 0.5 * bend}};
  return tf;
}

truth::Piece integrated(const truth::TransferCurve& curve, const truth::Cubic& value, double length,
                        double from, double to) {
  const auto cuts = truth::cuts_at_knots(value, curve.knots());
  truth::Piece seen;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double a = std::clamp(cuts[i], from, to), b = std::clamp(cuts[i + 1], from, to);
    const auto at = [&](double s) {
      const auto sample = curve.at(value.at(s));
      return truth::Medium{truth::extinction(sample.opacity) * length, sample.colour};
    };
    if (a < b) seen = behind(seen, truth::integrate(at, a, b, 1e-13));
  }
  return seen;
}

}  // namespace

TEST_CASE("along passages the field in 80 bits is what its polynomials say") {
  using Real = long double;
  const Volume volume = make_volume({9, 8, 7}, ScalarType::float64, pattern, {1, 1.2, 0.7});
  std::size_t wrong = 0, wide = 0, told_apart = 0, seen = 0;
  for (const Camera& camera : {cameras[0], cameras[3]}) {
    const truth::Scene scene = scene_of(volume, plain_spec(constant_opacity(0.5), 16, camera));
    for (const truth::Pixel pixel : truth::all_pixels(16, 16)) {
      const truth::LatticeRay ray = truth::Rays(scene).through(pixel);
      if (!(ray.enter < ray.leave)) continue;
      const truth::Way way = truth::way_along(scene, ray, {});
      for (std::size_t i = 0; i + 1 < way.cuts.size(); ++i) {
        const auto passage = truth::passage_between(scene, ray, way.cuts[i], way.cuts[i + 1]);
        truth::Corners<truth::Ball> corners;
        for (int c = 0; c < 8; ++c)
          corners[std::size_t(c)] = scene.values[scene.index(passage.cell.corner(c))];
        const Polynomial found = truth::along_passage(corners, passage);
        for (const double part : {0.0, 0.3, 1.0}) {
          const Real s = Real(way.cuts[i].at) + part * (Real(way.cuts[i + 1].at) - Real(way.cuts[i].at));
          Real exact = 0;
          for (int c = 0; c < 8; ++c) {
            Real weight = 1;
            for (int k = 0; k < 3; ++k) {
              const Real place = Real(ray.origin[k]) + s * Real(ray.step[k]) - passage.corner[k];
              weight *= (c >> k & 1) ? place : 1 - place;
            }
            exact += weight * Real(corners[std::size_t(c)].middle);
          }
          const Interval at = about(found, part)[0];
          wrong += !holds(at, double(exact), 1e-16);
          wide += width(at) > 1e-7;
          told_apart += !holds(at, double(exact) + 1e-6);
          ++seen;
        }
      }
    }
  }
  CHECK(seen > 1000);
  CHECK(wrong == 0);
  CHECK(wide == 0);
  CHECK(told_apart == seen);
}

TEST_CASE("pieces hold their integrals, also beside the line of the transfer function that has the series") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  std::size_t wrong = 0, off_line = 0, missed = 0, smooth = 0;
  for (const double bend : {0.0, 0.4, 0.8}) {
    TransferFunction without = bent(0);
    without.opacities.erase(without.opacities.begin() + 1);
    const truth::TransferCurve curve(bent(bend)), straight(without);
    const truth::EnclosedCurve lines(curve), one_line(straight);
    for (int trial = 0; trial < 1000; ++trial) {
      const truth::Cubic value{
          {0.5 + 0.03 * any(random), 0.2 * any(random), 0.1 * any(random), 0.05 * any(random)}};
      const bool thick = trial % 4 == 0;
      const double length = (thick ? 20 : 1) * (1.5 + any(random)), from = 0.4 + 0.4 * any(random),
                   to = std::min(1.0, from + 0.2);
      const truth::Part part(Interval(length), from, to);
      const auto medium = about({exactly(value), {}, std::nullopt, Interval(length)}, part.middle);
      const truth::Piece exact = integrated(curve, value, length, from, to);
      const auto extremes = extremes_of(lines, medium, part);
      wrong += !holds(between(extremes, part), exact);
      const auto series = expanded(lines, medium, extremes, part);
      const auto without_bend = expanded(one_line, medium, extremes_of(one_line, medium, part), part);
      smooth += series.has_value();
      wrong += series && !holds(*series, exact);
      if (bend == 0 || (value.at(from) < 0.5) == (value.at(to) < 0.5)) continue;
      ++off_line;
      missed += !holds(*without_bend, exact);  // as if nothing were beside the line
    }
  }
  CHECK(wrong == 0);
  CHECK(smooth > 500);
  CHECK(off_line > 30);
  CHECK(missed == off_line);
}

TEST_CASE("light on normals of a piece lies within its bounds and its series") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  const truth::Scene scene = scene_of(lump_volume(), plain_spec(constant_opacity(0.5), 16, cameras[0]));
  const truth::Phong phong(scene, truth::Rays(scene).view());
  const glm::dvec3 to_viewer = truth::Rays(scene).through({8, 8}).to_viewer;
  std::size_t wrong = 0, smooth = 0, one_sided = 0, told_apart = 0;
  for (int trial = 0; trial < 500; ++trial) {
    truth::Cubic components[3];
    truth::EnclosedNormal normal;
    for (std::size_t k = 0; k < 3; ++k) {
      components[k] = {{any(random), 0.5 * any(random), 0.2 * any(random), 0.1 * any(random)}};
      normal[k] = exactly(components[k]);
    }
    const auto light_at = [&](double s) {
      return phong.light({components[0].at(s), components[1].at(s), components[2].at(s)}, to_viewer);
    };
    const truth::Part part(Interval(1), 0.4, 0.6);
    for (Polynomial& p : normal) p = about(p, part.middle);
    const truth::EnclosedLight light(scene.frame.shown.material, phong.to_light(), to_viewer);
    const auto bounds = light.over(normal, part.reach());
    for (const double s : {0.4, 0.47, 0.5, 0.55, 0.6}) {
      const auto exact = light_at(s);
      wrong += !holds(bounds.scale, exact.scale) || !holds(bounds.highlight, exact.highlight);
    }
    if (!bounds.kind.smooth) continue;
    ++smooth;
    const auto series = light.series<4>(bounds.kind, normal, 0);
    const auto exact = light_at(0.5);
    // All that is missing makes it brighter.
    const auto made_up = [&](double found, double most, double of) {
      return found < of + 1e-11 && of < found + most + 1e-11;
    };
    wrong += !made_up(series.scale[0].middle, bounds.kind.missing, exact.scale);
    wrong += !made_up(series.highlight[0].middle, bounds.kind.missing, exact.highlight);
    // Its light comes from one side throughout.
    if (!(bounds.scale.lower() > scene.frame.shown.material.ambient)) continue;
    ++one_sided;
    wrong += !holds(series.scale[0], exact.scale);
    told_apart += !holds(series.scale[0], exact.scale + 1e-6);
  }
  CHECK(wrong == 0);
  CHECK(smooth > 100);
  CHECK(one_sided > 100);
  CHECK(told_apart == one_sided);
}

TEST_CASE("one piece seen through another holds what any members of both show") {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> part(0, 1);
  const auto between_two = [&](Interval& interval) {
    const double a = part(random), b = part(random), t = part(random);
    interval = {std::min(a, b), std::max(a, b)};
    return std::clamp(std::lerp(a, b, t), interval.lower(), interval.upper());
  };
  std::size_t wrong = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    truth::EnclosedPiece front, back;
    truth::Piece in_front, at_back;
    in_front.transmittance = between_two(front.transmittance);
    at_back.transmittance = between_two(back.transmittance);
    if (trial % 2 == 0) front.mean_of.emplace();
    for (std::size_t c = 0; c < 3; ++c) {
      double& colour = in_front.colour[int(c)];
      colour = between_two(front.mean_of ? (*front.mean_of)[c] : front.colour[c]);
      if (front.mean_of) colour *= 1 - in_front.transmittance;
      at_back.colour[int(c)] = between_two(back.colour[c]);
    }
    // Colours are no more than 1 together, as in all pictures.
    const truth::Piece both = behind(in_front, at_back);
    if (glm::any(glm::greaterThan(both.colour, glm::dvec3(1)))) continue;
    wrong += !holds(behind(front, back), both, 1e-15);
  }
  CHECK(wrong == 0);
}
