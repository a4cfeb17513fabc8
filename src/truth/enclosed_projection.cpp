#include "truth/enclosed_projection.hpp"

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

Cubic middle_of(const Polynomial& p) { return {{p[0].middle, p[1].middle, p[2].middle, p[3].middle}}; }

/// Adds the place where a cubic's slope turns to those that are between 0 and 1, ascending.
void cut_where_steepest(std::vector<double>& cuts, const Cubic& cubic) {
  const double steepest = -cubic.p[2] / (3 * cubic.p[3]);
  if (steepest > 0 && steepest < 1) cuts.insert(std::ranges::upper_bound(cuts, steepest), steepest);
}

/// Bernstein's coefficients over [from, to], between which the polynomial is; the first and the last are its
/// ends, and the mean of all is its own.
std::array<Interval, 4> bernstein_of(const Polynomial& p, double from, double to) {
  const Polynomial a = about(p, from), b = about(p, to);
  const Ball third = (Ball(to) - from) * one_over(3);
  return {a[0], a[0] + third * a[1], b[0] - third * b[1], b[0]};
}

class Projector : EnclosedTracer {
 public:
  explicit Projector(const Scene& scene) : EnclosedTracer(scene) {}

  PixelBounds operator()(Pixel pixel) const {
    return seen_by(pixel, [&](const LatticeRay& ray, const Way& way) {
      if (shown_.mode == Mode::surface) return first_surface(ray, way);
      if (shown_.mode == Mode::attenuated) return coloured(dimmed(ray, way), ray, way);
      const auto [value, surely] = projected(ray, way);
      const EnclosedPiece seen = coloured(value, ray, way);
      return surely ? seen : either(seen, {});
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
    return {{values}, values, false, near.has_value()};
  }

  std::optional<Stretch> in_cell(const Passage& passage) const {
    const auto corners = cell_values(scene_, curve_, passage.cell);
    if (!corners) return std::nullopt;
    const double extra = off_cell(passage);
    Interval values(corners->low, corners->high);
    if (extra > 0) values += within(extra);
    constexpr double largest = 1e250;  // of which sums and products are numbers
    if (!(largest_of(values) < largest)) return Stretch{{values}, values, false};
    Polynomial value = value_of(*corners, passage);
    if (extra > 0) value[0] = value[0] + Ball(0, extra);
    return Stretch{value, values, true};
  }

  /// A ray's extremum, mean or integral, and whether it surely has one.
  std::pair<Interval, bool> projected(const LatticeRay& ray, const Way& way) const {
    const TransferFunction& tf = shown_.transfer_function;
    const bool greatest = shown_.mode == Mode::mip;
    Interval extremum = greatest ? Interval(std::min(tf.colours.front().value, tf.opacities.front().value))
                                 : Interval(std::max(tf.colours.back().value, tf.opacities.back().value));
    Interval integral = 0, length = 0, met = Interval::empty();
    bool surely = false;
    for_stretches(ray, way, [&](const std::optional<Stretch>& s, const Passage& passage) {
      length += passage.length;
      surely = surely || (s && s->sure);
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
      const Interval part =
          passage.length * among_values(p0 + p1 * one_over(2) + p2 * one_over(3) + p3 * one_over(4));
      integral += s->sure ? part : hull(part, Interval(0));
      met = hull(met, s->values);
      return true;
    });
    if (shown_.mode == Mode::sum) return {integral * scene_.grid.unit_length(), true};
    if (shown_.mode != Mode::mean) return {extremum, surely};
    return {length.lower() > 0 ? clamped(integral / length, met.lower(), met.upper()) : met, true};
  }

  /// What was seen of a ray from the front.
  struct Dimmed {
    Interval depth = 0;
    double least = 0, most = 0;  ///< between which the most is that is left of a share
    int pieces_left = 0;         ///< of a cell's passage
  };

  Interval dimmed(const LatticeRay& ray, const Way& way) const {
    const TransferFunction& tf = shown_.transfer_function;
    const double low = tf.colours.front().value, high = tf.colours.back().value;
    if (!(low < high)) return low;
    constexpr double most_opacity = 0.999;
    double densest = 0;
    for (const auto& point : tf.opacities) densest = std::max(densest, std::min(point.opacity, most_opacity));
    const Interval dimming = -log_of(1.0 - Interval(densest)), window = Interval(high) - low;
    Dimmed seen;
    for_stretches(ray, way, [&](const std::optional<Stretch>& s, const Passage& passage) {
      if (!s) return true;
      Stretch shares = *s;
      shares.value[0] = shares.value[0] - low;
      for (Ball& c : shares.value) c = c * inverse_of(window);
      const Cubic cubic = middle_of(shares.value);
      std::vector<double> cuts = cuts_at_knots(cubic, {0.0, 1.0});
      cut_where_steepest(cuts, cubic);
      seen.pieces_left = 1'000;
      for (std::size_t i = 0; i + 1 < cuts.size(); ++i)
        look_for_most(shares, dimming * passage.length, cuts[i], cuts[i + 1], seen);
      return true;
    });
    return low + window * Interval(seen.least, seen.most);
  }

  /// In halves, where more may be left than what surely is.
  /// `shares`: of the colours' window; `dense`: the depth of all of it, were they 1.
  void look_for_most(const Stretch& shares, const Interval& dense, double from, double to,
                     Dimmed& seen) const {
    const Part part(dense, from, to);
    const auto [begin, one, other, end] = bernstein_of(shares.value, from, to);
    // Shares outside of the window count as its ends.
    const Interval all = hull(hull(begin, one), hull(end, other)), share = clamped(all, 0, 1);
    const double cut_off = std::max({0.0, -all.lower(), all.upper() - 1});
    Interval slope = series_of<1>(about(shares.value, part.middle), part.reach())[1];
    if (cut_off > 0) slope = hull(slope, Interval(0));
    const Interval mean = (begin + one + other + end) / 4.0 + within(cut_off);
    Interval passed = part.length * intersect(mean, share);
    if (!shares.sure) passed = hull(passed, Interval(0));
    const Interval behind = seen.depth + passed, light = exp_of(-hull(seen.depth, behind));
    const auto left = [&](const Interval& value, const Interval& depth) {
      return clamped(value, 0, 1) * exp_of(-depth);
    };
    const Interval first = left(begin, seen.depth), last = left(end, behind),
                   change = light * (slope - dense * square(share));
    double most = (share * light).upper();
    if (shares.sure) {
      seen.least = std::max({seen.least, first.lower(), last.lower()});
      // By the mean value theorem; what rises throughout is greatest at its end.
      const Interval greatest = change.lower() >= 0 ? last : first + hull(0.0, 2.0 * part.half) * change;
      most = std::min(most, greatest.upper());
    }
    // What is open at a place no halving closes.
    const double enough = 1e-9 + std::max(width(first), width(last));
    constexpr double shortest = 1e-8;
    --seen.pieces_left;
    if (shares.sure && shares.in_one_cell && most > std::max(seen.least + enough, seen.most) &&
        to - from > shortest && seen.pieces_left > 0) {
      look_for_most(shares, dense, from, median(part.middle), seen);
      return look_for_most(shares, dense, median(part.middle), to, seen);
    }
    seen.most = std::max(seen.most, most);
    seen.depth = behind;
  }

  EnclosedPiece coloured(const Interval& value, const LatticeRay& ray, const Way& way) const {
    const Interval any{0, 1};
    // Whatever was no number proves nothing.
    if (!(value.lower() <= value.upper())) return {{any, any, any}, any};
    auto colours = lines_.over(value);
    const Interval opacity = shown_.mode == Mode::attenuated ? 1 : colours[EnclosedCurve::opacity];
    if (scene_.is_slice() && tints_.any()) tint_slice(colours, ray, way);
    const auto& [red, green, blue, same_opacity] = colours;
    return {{red * opacity, green * opacity, blue * opacity}, 1.0 - opacity};
  }

  /// By the voxel nearest to where a ray is half through, if it is sure.
  void tint_slice(EnclosedCurve::Channels& colours, const LatticeRay& ray, const Way& way) const {
    const glm::dvec3 place = ray.at(0.5 * (way.enter.at + way.leave.at)),
                     by = 2 * tube + 0.5 * (way.enter.by + way.leave.by) * glm::abs(ray.step);
    const glm::ivec3 voxel = nearest_voxel(place - by, scene_.grid.dims);
    const bool sure = voxel == nearest_voxel(place + by, scene_.grid.dims);
    for (std::size_t c = 0; c < EnclosedCurve::opacity; ++c)
      colours[c] = sure ? tinted(colours[c], tints_.of(voxel), c) : Interval(0, 1);
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
        look(medium_of(ray, passage, *cell_values(scene_, curve_, passage.cell), off_cell(passage)), 0, 1,
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
  void look(const CellMedium& cell, double from, double to, Search& search) const {
    const Part part(1, from, to);
    --search.pieces_left;
    if (one_sided(series_of<0>(about(cell.value, part.middle), part.reach())[0], search)) return;
    constexpr double shortest = 1e-8;
    if (to - from < shortest || search.pieces_left <= 0) {
      const CellMedium here = about(cell, part.middle);
      return see(here.light ? here.light->over(here.normal, part.reach()) : unlit(), search);
    }
    const double middle = 0.5 * (from + to);
    look(cell, from, middle, search);
    if (!search.found) look(cell, middle, to, search);
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
};

}  // namespace

Interval greatest_of(const Polynomial& p) {
  const Cubic cubic = middle_of(p);
  std::vector<double> cuts = monotone_pieces(cubic);
  cut_where_steepest(cuts, cubic);
  double low = -std::numeric_limits<double>::infinity(), high = low;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    // Where the slope has one sign and does not turn these lie between the ends, but for rounding.
    const auto coefficients = bernstein_of(p, cuts[i], cuts[i + 1]);
    low = std::max({low, coefficients.front().lower(), coefficients.back().lower()});
    for (const Interval& c : coefficients) high = std::max(high, c.upper());
  }
  return {low, high};
}

std::vector<PixelBounds> projected_bounds(const Scene& scene, std::span<const Pixel> pixels) {
  return along_rays(scene, pixels, Projector(scene));
}

}  // namespace ringsplat::truth
