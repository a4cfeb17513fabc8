#include "truth/enclosed_projection.hpp"

#include <algorithm>
#include <limits>
#include <optional>

#include "truth/cubic.hpp"
#include "truth/enclosed_tracer.hpp"

namespace ringsplat::truth {
namespace {

/// The values along a part of a ray.
struct Stretch {
  Polynomial value;  ///< of the part of it
  Interval values;   ///< between which all are
  bool in_one_cell;  ///< `value` says more than `values`
  bool sure = true;  ///< may otherwise be without a value
};

EnclosedPiece either(const EnclosedPiece& one, const EnclosedPiece& other) {
  EnclosedPiece all{{}, hull(one.transmittance, other.transmittance)};
  for (std::size_t c = 0; c < 3; ++c) all.colour[c] = hull(one.colour[c], other.colour[c]);
  return all;
}

class Projector : EnclosedTracer {
 public:
  explicit Projector(const Scene& scene) : EnclosedTracer(scene), shown_(scene.frame.shown) {}

  PixelBounds along(Pixel pixel) const {
    return seen_by(pixel, [&](const LatticeRay& ray, const Way& way) {
      return shown_.mode == Mode::surface ? first_surface(ray, way) : coloured(projected(ray, way), ray, way);
    });
  }

 private:
  /// Calls see(stretch, passage) for all of a ray from its front until that returns false; the stretch is
  /// missing where there is no value.
  template <class See>
  void for_stretches(const LatticeRay& ray, const Way& way, const See& see) const {
    for_passages(ray, way, [&](const Passage& passage) {
      const bool known = passage.length.lower() > 0 && !beside_other_medium(ray, passage);
      return see(known ? in_cell(passage) : beside_cells(ray, passage), passage);
    });
  }

  Stretch beside_cells(const LatticeRay& ray, const Passage& passage) const {
    const auto near = values_near(ray, passage);
    const Interval values = near.value_or(values_);
    return {{values, 0.0, 0.0, 0.0}, values, false, near.has_value()};
  }

  std::optional<Stretch> in_cell(const Passage& passage) const {
    const auto corners = cell_values(scene_, curve_, passage.cell);
    if (!corners) return std::nullopt;
    const double extra = off_cell(passage);
    Interval values(corners->low, corners->high);
    if (extra > 0) values += within(extra);
    constexpr double largest = 1e250;  // of which sums and products are numbers
    if (!(largest_of(values) < largest)) return Stretch{{values, 0.0, 0.0, 0.0}, values, false};
    Polynomial value = value_of(*corners, passage);
    if (extra > 0) value[0] += within(extra);
    return Stretch{value, values, true};
  }

  /// A ray's extremum, mean or integral.
  Interval projected(const LatticeRay& ray, const Way& way) const {
    const TransferFunction& tf = shown_.transfer_function;
    const bool greatest = shown_.mode == Mode::mip;
    Interval extremum = greatest ? Interval(std::min(tf.colours.front().value, tf.opacities.front().value))
                                 : Interval(std::max(tf.colours.back().value, tf.opacities.back().value));
    Interval integral = 0, length = 0, met = Interval::empty();
    for_stretches(ray, way, [&](const std::optional<Stretch>& s, const Passage& passage) {
      length += passage.length;
      if (!s || !s->sure) met = hull(met, Interval(0));
      if (!s) return true;
      const auto& [p0, p1, p2, p3] = s->value;
      const auto among_values = [&](const Interval& x) {
        return clamped(x, s->values.lower(), s->values.upper());
      };
      if (greatest || shown_.mode == Mode::minip) {
        const Interval further = greatest ? max(extremum, among_values(greatest_of(s->value)))
                                          : min(extremum, among_values(-greatest_of({-p0, -p1, -p2, -p3})));
        extremum = s->sure ? further : hull(extremum, further);
      }
      const Interval part = passage.length * among_values(p0 + p1 / 2.0 + p2 / 3.0 + p3 / 4.0);
      integral += s->sure ? part : hull(part, Interval(0));
      met = hull(met, s->values);
      return true;
    });
    if (shown_.mode == Mode::sum) {
      const glm::dvec3& spacing = scene_.grid.spacing;
      return integral * std::min({spacing.x, spacing.y, spacing.z});
    }
    if (shown_.mode != Mode::mean) return extremum;
    return length.lower() > 0 ? clamped(integral / length, met.lower(), met.upper()) : met;
  }

  EnclosedPiece coloured(const Interval& value, const LatticeRay& ray, const Way& way) const {
    const Interval any{0, 1};
    // Whatever was no number proves nothing.
    if (!(value.lower() <= value.upper())) return {{any, any, any}, any};
    auto colours = lines_.over(value);
    const Interval opacity = colours[EnclosedCurve::opacity];
    if (scene_.is_slice() && tints_.any()) tint_slice(colours, ray, way);
    const auto& [red, green, blue, same_opacity] = colours;
    return {{red * opacity, green * opacity, blue * opacity}, 1.0 - opacity};
  }

  /// By the voxels that may be nearest to where a ray is half through.
  void tint_slice(EnclosedCurve::Channels& colours, const LatticeRay& ray, const Way& way) const {
    const Interval middle = 0.5 * (way.enter.exact() + way.leave.exact());
    glm::dvec3 low, high;
    for (int k = 0; k < 3; ++k) {
      const Interval place = Interval(ray.origin[k]) + middle * ray.step[k] + within(tube);
      low[k] = place.lower();
      high[k] = place.upper();
    }
    const Cell near{nearest_voxel(low, scene_.grid.dims), nearest_voxel(high, scene_.grid.dims)};
    const bool few = glm::all(glm::lessThanEqual(near.high - near.low, glm::ivec3(1)));
    for (std::size_t c = 0; c < EnclosedCurve::opacity; ++c) {
      Interval all = few ? Interval::empty() : Interval(0, 1);
      for (int corner = 0; corner < 8; ++corner)
        all = hull(all, tinted(colours[c], tints_.of(near.corner(corner)), c));
      colours[c] = all;
    }
  }

  struct Search {
    std::optional<bool> above = std::nullopt;  ///< the side of the surface that the ray was surely on
    bool found = false;                        ///< surely crossed, in what was seen
    std::optional<EnclosedPiece> seen = std::nullopt;
    int pieces_left = 0;  ///< of a cell's passage
  };

  /// Whether a ray is on one side of the surface here; found if it was on the other one before.
  bool one_sided(const Interval& values, Search& search) const {
    const bool above = values.lower() >= shown_.isovalue;
    if (!above && !(values.upper() < shown_.isovalue)) return false;
    search.found = search.above.value_or(above) != above;
    search.above = above;
    return true;
  }

  EnclosedPiece first_surface(const LatticeRay& ray, const Way& way) const {
    constexpr int most_pieces = 1'000;
    Search search;
    for_stretches(ray, way, [&](const std::optional<Stretch>& s, const Passage& passage) {
      search.pieces_left = most_pieces;
      if (s && s->in_one_cell && !one_sided(s->values, search))
        look(s->value, medium_of(ray, passage, *cell_values(scene_, curve_, passage.cell), 0).light, 0, 1,
             search);
      else if (s && !s->in_one_cell && !one_sided(s->values, search))
        see(scene_.shaded() ? EnclosedLight::any(shown_.material) : unlit(), search);
      if (!s || !s->sure) search = {.seen = search.seen};
      return !search.found;
    });
    if (!search.seen) return {};
    return search.found ? *search.seen : either(*search.seen, {});
  }

  /// In halves, until these are on one side or too short.
  void look(const Polynomial& value, const std::optional<EnclosedLight>& light, double from, double to,
            Search& search) const {
    const Part part(1, from, to);
    --search.pieces_left;
    if (one_sided(series_of<0>(value, part.middle, part.reach())[0], search)) return;
    constexpr double shortest = 1e-8;
    if (to - from < shortest || search.pieces_left <= 0)
      return see(light ? light->over(part.middle, part.reach()) : unlit(), search);
    const double middle = 0.5 * (from + to);
    look(value, light, from, middle, search);
    if (!search.found) look(value, light, middle, to, search);
  }

  static EnclosedLight::Bounds unlit() { return {1, 0, {}}; }
  void see(EnclosedLight::Bounds light, Search& search) const {
    EnclosedPiece piece{{}, 0};
    // The field may be level, which leaves the colour as it is.
    if (!light.kind.smooth) light.scale = hull(light.scale, Interval(1));
    const auto colour = lines_.over(Interval(shown_.isovalue));
    for (std::size_t c = 0; c < 3; ++c)
      piece.colour[c] = clamped(colour[c] * light.scale + light.highlight, 0, 1);
    search.seen = search.seen ? either(*search.seen, piece) : piece;
  }

  const Shown& shown_;
};

}  // namespace

Interval greatest_of(const Polynomial& p) {
  if (std::all_of(p.begin() + 1, p.end(), [](const Interval& c) { return c.lower() == 0 && c.upper() == 0; }))
    return p[0];
  const Cubic cubic{{median(p[0]), median(p[1]), median(p[2]), median(p[3])}};
  std::vector<double> cuts = monotone_pieces(cubic);
  const double steepest = -cubic.p[2] / (3 * cubic.p[3]);
  if (steepest > 0 && steepest < 1) cuts.insert(std::ranges::upper_bound(cuts, steepest), steepest);
  double low = -std::numeric_limits<double>::infinity(), high = low;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const auto a = series_of<2>(p, cuts[i], 0), b = series_of<2>(p, cuts[i + 1], 0);
    const Interval length = Interval(cuts[i + 1]) - cuts[i];
    // Bernstein's coefficients of the slope have one sign, but for rounding.
    const Interval slope = hull(hull(a[1], a[1] + length * a[2]), b[1]),
                   rising = b[0] - length * std::min(0.0, slope.lower()),
                   falling = a[0] + length * std::max(0.0, slope.upper());
    low = std::max({low, a[0].lower(), b[0].lower()});
    high = std::max(high, std::min(rising.upper(), falling.upper()));
  }
  return {low, high};
}

std::vector<PixelBounds> projected_bounds(const Scene& scene, std::span<const Pixel> pixels) {
  const Projector projector(scene);
  return along_rays(scene, pixels, [&](Pixel pixel) { return projector.along(pixel); });
}

}  // namespace ringsplat::truth
