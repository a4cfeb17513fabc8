#include "truth/slab_integral.hpp"

#include <cmath>

#include "truth/quadrature.hpp"
#include "truth/ray.hpp"

namespace ringsplat::truth {
namespace {

/// Mean of −ln(1 − o) over the opacities from `a` to `b`.
double mean_extinction(double a, double b) {
  const double y0 = 1 - a, y1 = 1 - b;
  if (std::abs(a - b) <= 0.01 * std::min(y0, y1)) {
    // The closed form would be a difference of almost equal numbers. Three Gauss points leave 1e-14.
    const double outer = std::sqrt(0.6), middle = 0.5 * (a + b), half = 0.5 * (b - a);
    return (5 * extinction(middle - outer * half) + 8 * extinction(middle) +
            5 * extinction(middle + outer * half)) /
           18;
  }
  const auto integral = [](double y) { return y > 0 ? y - y * std::log(y) : 0.0; };
  return (integral(y0) - integral(y1)) / (y0 - y1);
}

/// Part [from, to] of a slab [0, 1], on which opacity a unit length and colour are linear.
struct LinearPart {
  double from, to;
  double opacity_from, opacity_to;
  glm::dvec3 colour_from, colour_to;
  double depth_before;  ///< optical depth of the slab up to `from`
  double length;        ///< of the whole slab

  double depth_at(double t) const {
    if (t <= from) return depth_before;
    const double x = (t - from) / (to - from);
    return depth_before +
           length * (t - from) *
               mean_extinction(opacity_from, opacity_from + std::min(x, 1.0) * (opacity_to - opacity_from));
  }
  double hidden_at(double t) const { return -std::expm1(-depth_at(t)); }
};

/// Integrals of h (x) and t h (y), h = 1 − transmittance.
using Moments = glm::dvec2;

Moments lobatto(const LinearPart& part, double a, double b) {
  const Rule& rule = lobatto_rule();
  Moments sum(0.0);
  for (std::size_t i = 0; i < rule_nodes; ++i) {
    const double t = a + (b - a) * rule.node[i], h = (b - a) * rule.weight[i] * part.hidden_at(t);
    sum += Moments(h, t * h);
  }
  return sum;
}

Moments halved(const LinearPart& part, double a, double b, const Moments& whole, int halvings_left) {
  const double middle = 0.5 * (a + b);
  const Moments front = lobatto(part, a, middle), back = lobatto(part, middle, b), both = front + back;
  // Of next to nothing a share would be below rounding, and halving would not end.
  const double tolerance = std::max(1e-12 * part.hidden_at(part.to), std::numeric_limits<double>::min());
  if (std::abs(both.x - whole.x) <= tolerance && std::abs(both.y - whole.y) <= tolerance) return both;
  if (halvings_left == 0 || !(a < middle && middle < b)) return both;
  return halved(part, a, middle, front, halvings_left - 1) + halved(part, middle, b, back, halvings_left - 1);
}

double mixed(double a, double b, double t) { return a == b ? a : (1 - t) * a + t * b; }

/// The lines of opacity and colour that hold inside (from, to): a jump at an end belongs to the neighbour.
LinearPart linear_part(const TransferCurve& curve, double front, double back, double from, double to,
                       double depth_before, double length) {
  const auto at = [&](double x) { return curve.at(mixed(front, back, from + x * (to - from))); };
  const auto near = at(0.25), far = at(0.75);
  const auto end = [](const auto& here, const auto& there) { return 1.5 * here - 0.5 * there; };
  return {from,
          to,
          std::clamp(end(near.opacity, far.opacity), 0.0, 1.0),
          std::clamp(end(far.opacity, near.opacity), 0.0, 1.0),
          glm::clamp(end(near.colour, far.colour), 0.0, 1.0),
          glm::clamp(end(far.colour, near.colour), 0.0, 1.0),
          depth_before,
          length};
}

/// Places in [0, 1], ascending, both ends among them, where the value crosses a point.
std::vector<double> cuts_at_knots(const std::vector<double>& knots, double front, double back) {
  std::vector<double> cuts{0.0, 1.0};
  const auto [low, high] = std::minmax({front, back});
  for (auto k = std::upper_bound(knots.begin(), knots.end(), low); k != knots.end() && *k < high; ++k)
    cuts.push_back(std::clamp((0.5 * *k - 0.5 * front) / (0.5 * back - 0.5 * front), 0.0, 1.0));
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

}  // namespace

SlabIntegral integrate_slab(const TransferCurve& curve, double front, double back, double length) {
  const auto cuts = cuts_at_knots(curve.knots(), front, back);
  constexpr int most_halvings = 30;
  Moments sum(0.0);
  glm::dvec3 colour(0.0);
  double depth = 0;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    if (!(cuts[i] < cuts[i + 1])) continue;
    const LinearPart part = linear_part(curve, front, back, cuts[i], cuts[i + 1], depth, length);
    const double before = -std::expm1(-depth);
    depth = part.depth_at(part.to);
    if (std::isinf(depth)) {  // nothing is seen behind its front
      colour += (1 - before) * part.colour_from;
      sum += Moments(1 - part.from, 0.5 * (1 - part.from * part.from));
      break;
    }
    // By parts: the integral of c dh is c h at the ends less that of h dc.
    const Moments here = halved(part, part.from, part.to, lobatto(part, part.from, part.to), most_halvings);
    colour += part.colour_to * -std::expm1(-depth) - part.colour_from * before -
              (part.colour_to - part.colour_from) * (here.x / (part.to - part.from));
    sum += here;
  }
  SlabIntegral slab;
  slab.opacity = -std::expm1(-depth);
  if (!(slab.opacity > 0)) return {};
  slab.colour = glm::clamp(colour / slab.opacity, 0.0, 1.0);
  slab.centroid = std::clamp(1 - sum.x / slab.opacity, 0.0, 1.0);
  const double square = 1 - 2 * sum.y / slab.opacity;
  slab.spread = std::sqrt(std::max(0.0, square - slab.centroid * slab.centroid));
  return slab;
}

}  // namespace ringsplat::truth
