#include "truth/quadrature.hpp"

#include <cmath>

namespace ringsplat::truth {
namespace {

using Nodes = std::array<double, rule_nodes>;

/// Both ends and the zeros of the derivative of Legendre's polynomial of degree four (Abramowitz and Stegun
/// 1964, table 25.6), in closed form and moved to [0, 1].
Nodes lobatto_abscissae() {
  const double inner = std::sqrt(3.0 / 7);
  return {0.0, 0.5 * (1 - inner), 0.5, 0.5 * (1 + inner), 1.0};
}

double lagrange(const Nodes& nodes, std::size_t j, double x) {
  double product = 1;
  for (std::size_t m = 0; m < rule_nodes; ++m)
    if (m != j) product *= (x - nodes[m]) / (nodes[j] - nodes[m]);
  return product;
}

/// Each weight is the integral of its node's Lagrange polynomial: of degree four, which three Gauss points
/// integrate exactly.
Rule make_rule(const Nodes& nodes) {
  const double outer = std::sqrt(0.6);
  const double place[3] = {0.5 * (1 - outer), 0.5, 0.5 * (1 + outer)},
               share[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  Rule rule{nodes, {}, {}};
  for (std::size_t j = 0; j < rule_nodes; ++j)
    for (int g = 0; g < 3; ++g) {
      rule.weight[j] += share[g] * lagrange(nodes, j, place[g]);
      for (std::size_t i = 0; i < rule_nodes; ++i)
        rule.up_to[i][j] += nodes[i] * share[g] * lagrange(nodes, j, nodes[i] * place[g]);
    }
  return rule;
}

}  // namespace

const Rule& lobatto_rule() {
  static const Rule rule = make_rule(lobatto_abscissae());
  return rule;
}

}  // namespace ringsplat::truth
