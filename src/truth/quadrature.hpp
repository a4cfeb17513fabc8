#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/vec3.hpp>

namespace ringsplat::truth {

/// The medium at a point of a ray: extinction and straight colour.
struct Medium {
  double extinction = 0;  ///< per unit length, the ray's parameter; infinite where opaque
  glm::dvec3 colour{0.0};
};

/// The contribution of a piece of a ray, seen from its front.
struct Piece {
  glm::dvec3 colour{0.0};
  double transmittance = 1;
};
inline Piece behind(const Piece& front, const Piece& back) {
  return {front.colour + front.transmittance * back.colour, front.transmittance * back.transmittance};
}

/// Nodes on [0, 1] with the weights of the whole interval, and of [0, node i] by collocation (Hairer, Nørsett
/// and Wanner 1993, section II.7).
inline constexpr std::size_t rule_nodes = 5;
using Nodes = std::array<double, rule_nodes>;
struct Rule {
  Nodes node, weight;
  std::array<Nodes, rule_nodes> up_to;  ///< [i][j]: weight of node j over [0, node i]
};
inline double lagrange(const Nodes& nodes, std::size_t j, double x) {
  double product = 1;
  for (std::size_t m = 0; m < rule_nodes; ++m)
    if (m != j) product *= (x - nodes[m]) / (nodes[j] - nodes[m]);
  return product;
}

/// Lobatto's nodes, which include both ends: no jump or bend can hide between an outer node and the end. The
/// end nodes lie 1e-9 of the length inside, so that a jump at the end itself has no effect.
inline const Rule& lobatto_rule() {
  static const Rule lobatto = [] {
    // Both ends and the zeros of the derivative of Legendre's polynomial of degree four (Abramowitz and
    // Stegun 1964, table 25.6), in closed form and moved to [0, 1].
    const double inner = std::sqrt(3.0 / 7), outer = std::sqrt(0.6);
    Rule rule{{0.0, 0.5 * (1 - inner), 0.5, 0.5 * (1 + inner), 1.0}, {}, {}};
    // Each weight is the integral of its node's Lagrange polynomial: of degree four, which three Gauss points
    // integrate exactly.
    const double place[3] = {0.5 * (1 - outer), 0.5, 0.5 * (1 + outer)},
                 share[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    for (std::size_t j = 0; j < rule_nodes; ++j)
      for (int g = 0; g < 3; ++g) {
        rule.weight[j] += share[g] * lagrange(rule.node, j, place[g]);
        for (std::size_t i = 0; i < rule_nodes; ++i)
          rule.up_to[i][j] += rule.node[i] * share[g] * lagrange(rule.node, j, rule.node[i] * place[g]);
      }
    return rule;
  }();
  return lobatto;
}

/// Replaces infinite extinction at a single node: −ln of the smallest 1 − α that a double holds. If opacity 1
/// covers a length, halving finds pieces that are opaque throughout; if it is reached at a point only, the
/// depth stays finite.
inline constexpr double almost_opaque = 37;

/// One application of the rule to t in [a, b]: the optical depth at each node, then the emission. An opaque
/// piece shorter than `thinnest` may be a point that was rounded to a length.
template <class At>
Piece lobatto_piece(const At& at, double a, double b, double thinnest) {
  const Rule& rule = lobatto_rule();
  std::array<Medium, rule_nodes> medium;
  std::size_t opaque = 0;
  for (std::size_t i = 0; i < rule_nodes; ++i) {
    medium[i] = at(a + (b - a) * std::clamp(rule.node[i], 1e-9, 1 - 1e-9));
    if (std::isinf(medium[i].extinction)) {
      ++opaque;
      medium[i].extinction = almost_opaque;
    }
    medium[i].extinction *= b - a;
  }
  if (opaque == rule_nodes && b - a >= thinnest) return {medium[0].colour, 0};
  Piece piece;
  double whole = 0;
  for (std::size_t i = 0; i < rule_nodes; ++i) {
    double depth = 0;
    for (std::size_t j = 0; j < rule_nodes; ++j) depth += rule.up_to[i][j] * medium[j].extinction;
    piece.colour += rule.weight[i] * medium[i].extinction * std::exp(-depth) * medium[i].colour;
    whole += rule.weight[i] * medium[i].extinction;
  }
  piece.transmittance = std::exp(-whole);
  return piece;
}

/// Halvings of one interval in all: values that are steep beyond rounding are stairs, and each step a jump.
inline constexpr int all_halvings = 8192;

/// Halves [a, b] until two halves agree with the whole to `tolerance` (in colour, shared out by length) or to
/// rounding. The front takes at most half of the halvings left, or as many as one place needs.
template <class At>
Piece adaptive_piece(const At& at, double a, double b, const Piece& whole, double tolerance, double thinnest,
                     int& halvings_left, int depth = 0) {
  // Rounding changes a piece by less: a smaller tolerance could be missed however often it is halved.
  constexpr double least_change = 1e-14;
  // Of one place: its piece is then some 1e-12 of the interval.
  constexpr int most_halvings = 40;
  const double middle = 0.5 * (a + b);
  const Piece front = lobatto_piece(at, a, middle, thinnest), back = lobatto_piece(at, middle, b, thinnest);
  const Piece both = behind(front, back);
  double change = std::abs(both.transmittance - whole.transmittance);
  for (int c = 0; c < 3; ++c) change = std::max(change, std::abs(both.colour[c] - whole.colour[c]));
  if (change <= std::max(least_change, tolerance) || !(a < middle && middle < b)) return both;
  if (depth == most_halvings || halvings_left == 0) return both;
  --halvings_left;
  int in_front = std::min(halvings_left, std::max(halvings_left / 2, most_halvings));
  halvings_left -= in_front;
  const Piece fine_front =
      adaptive_piece(at, a, middle, front, 0.5 * tolerance, thinnest, in_front, depth + 1);
  halvings_left += in_front;
  // The tolerance behind grows as less of it is seen.
  const double behind_it = 0.5 * tolerance / std::max(fine_front.transmittance, 1e-12);
  return behind(fine_front,
                adaptive_piece(at, middle, b, back, behind_it, thinnest, halvings_left, depth + 1));
}

/// `tolerance`: above zero. Calls `at` 15 times and 20 times a halving.
template <class At>
Piece integrate(const At& at, double a, double b, double tolerance) {
  const double thinnest = 1e-6 * (b - a);
  int halvings_left = all_halvings;
  return adaptive_piece(at, a, b, lobatto_piece(at, a, b, thinnest), tolerance, thinnest, halvings_left);
}

}  // namespace ringsplat::truth
