// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_PROJECTION_PAINTER_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_PROJECTION_PAINTER_INL
#undef RINGSPLAT_PROJECTION_PAINTER_INL
#else
#define RINGSPLAT_PROJECTION_PAINTER_INL
#endif

#include "sheet_engine/tile_painter-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// The values along a piece of a ray: f0 + f1 s + f2 s² + f3 s³, s from 0 to 1.
struct RayCubic {
  F f0, f1, f2, f3;

  HWY_INLINE F at(F s) const { return fma(fma(fma(f3, s, f2), s, f1), s, f0); }
  HWY_INLINE F integral() const {
    return fma(set(0.25F), f3, fma(set(1.0F / 3), f2, fma(set(0.5F), f1, f0)));
  }
  /// Two places in [0, 1], ascending, between which and the ends it is monotone. Where it turns nowhere they
  /// are any.
  HWY_INLINE void turns(F& first, F& second) const {
    const F zero = set(0.0F), a = mul(set(3.0F), f3);
    const F under = fma(f2, f2, sub(zero, mul(a, f1)));
    const F square = root(max(under, zero));
    // Both terms have one sign, so that nothing cancels.
    const F q = sub(zero, add(f2, choose(greater(zero, f2), sub(zero, square), square)));
    // A quotient that is not a number becomes a limit: its place is as good as any.
    const F x = max(min(div(q, a), set(1.0F)), zero), y = max(min(div(f1, q), set(1.0F)), zero);
    first = min(x, y);
    second = max(x, y);
  }
};

/// From a place in a cell to another, in [0, 1].
struct CellPath {
  F u, v, du, dv;

  /// The values along it, of the slice's bilinear interpolation.
  HWY_INLINE RayCubic values(const CellCorners& c) const {
    const F across = sub(c.right, c.at), down = sub(c.below, c.at), twist = sub(sub(c.across, c.right), down);
    const F along_u = fma(twist, v, across), along_v = fma(twist, u, down);
    return {fma(along_u, u, fma(down, v, c.at)), fma(du, along_u, mul(dv, along_v)), mul(twist, mul(du, dv)),
            set(0.0F)};
  }
};

/// Paints what is projected along rays instead of composited: extrema, integrals, a first surface. The field
/// is cubic along a ray inside a cell (Parker et al. 1998), so all are exact but for rounding, and but for
/// dimmed extrema. Pixels hold
///   in red how far an extremum is beyond Projection::least, and 1 in opacity once more changes nothing;
///   in green by how many powers of two what lies behind is dimmed;
///   an integral in red, of what is above or below the value 0;
///   a surface's premultiplied colour, or with Projection::values in red its slice, from the middle one.
template <class Sampler, class Rays, class State = TilePixels<Rays>>
class ProjectionPainter : public TilePainter<Sampler, Rays, State> {
  using Base = TilePainter<Sampler, Rays, State>;

 protected:
  using Base::count_, Base::list_, Base::p_, Base::plane_of, Base::rays_, Base::slab_, Base::state_;

 public:
  using Base::Base;

  void paint(const SheetSlab& slab, TileMask mask) {
    this->begin(slab, mask);
    for (int k = 0; k < count_; ++k) paint_tile(state_[list_[k]]);
  }

 protected:
  /// Lanes' way through the slab along u or v. Places count from the voxel below the first; `w` runs from 0
  /// at the slab's front to 1 at its back.
  struct Along {
    I base;        ///< that voxel
    F from, way;   ///< the first place, and the way to the last
    I cell, turn;  ///< the voxel below the cell in which a lane is, and the way to the next cell
    F next, step;  ///< the cell's border, and from border to border, as w

    HWY_INLINE Along(I first, I last, F w) {
      const F zero = set(0.0F), one = set(1.0F), over = set(1.0F / one_voxel);
      base = down_signed<position_bits>(first);
      from = mul(to_float(both(first, set_int(one_voxel - 1))), over);
      way = mul(to_float(sub(last, first)), over);
      const M rises = greater(way, zero), rests = equal(way, zero);
      const F at = fma(way, w, from), below = floor(at),
              border = choose(rises, add(below, one), sub(zero, add(floor(sub(zero, at)), one)));
      turn = choose(rises, set_int(1), set_int(-1));
      cell = add(base, to_int(choose(either(rises, rests), below, border)));
      const F over_way = div(one, way), never = set(1e9F);
      next = choose(rests, never, mul(sub(border, from), over_way));
      step = min(abs(over_way), never);
    }
    /// Walks to w = `end`.
    HWY_INLINE void go(F end) {
      const M stays = greater(next, end);
      next = choose(stays, next, add(next, step));
      cell = choose(stays, cell, add(cell, turn));
    }
    /// The cell in the box. Beyond the outer voxels the field has their values.
    HWY_INLINE I cell_in_box(int voxels) const {
      return min(max(cell, set_int(0)), set_int(std::max(voxels - 2, 0)));
    }
    /// The place at w in a cell of the box.
    HWY_INLINE F place(F w, I in_cell) const {
      return min(max(sub(fma(way, w, from), to_float(sub(in_cell, base))), set(0.0F)), set(1.0F));
    }
  };
  /// A tile's lanes in the slab.
  struct Walk {
    Corner corner;
    Along u, v;
    F w, enter;
    M inside{}, inside_last{};  ///< whether the field is above the surface's value at w, and at the back
    M known{}, known_last{};    ///< where it is a number

    HWY_INLINE void go(F end) {
      u.go(end);
      v.go(end);
      w = end;
    }
  };
  /// The slices before and behind the slab.
  struct PlanePair {
    typename Sampler::Plane front, back;
  };
  /// The cell between them in which each lane is.
  struct CellOfLanes {
    I u, v;
    typename Sampler::Sheet sheet;
  };
  /// A part of lanes' way inside one cell.
  struct Part {
    RayCubic values;
    F from, to;  ///< of w
    F most;      ///< how far the extremum of the cell's corners is
    M there;     ///< lanes that have such a part
    HWY_INLINE F length() const { return sub(to, from); }
  };

  /// Finds a tile's lanes that still take something. False where there are none, or all lie behind a clip
  /// plane.
  HWY_INLINE bool begin_tile(State& s, M& alive, bool& by_planes) const {
    alive = this->alive(s);
    s.dead = !any(alive);
    if (s.dead) return false;
    M seen = alive;
    by_planes = this->cut_by_planes(s, seen);
    return any(seen);
  }

  HWY_INLINE Walk walk_of(const State& s, Corner corner, const Way& way) const {
    const Position from = rays_.at(s.ray, 0), to = rays_.at(s.ray, slab_->pieces);
    return Walk{corner, Along(from.u, to.u, way.enter), Along(from.v, to.v, way.enter), way.enter, way.enter};
  }
  HWY_INLINE Way way_of(const State& s, const Ends& ends, bool by_planes) const {
    const bool cut = Rays::some_miss(s.ray) || by_planes || this->leaves(ends, one_voxel / 2 - 1);
    return cut ? this->way_in_box(s, 0) : Way{set(0.0F), set(1.0F)};
  }
  HWY_INLINE PlanePair planes_of(const SheetSlab& slab, Corner corner) const {
    return {plane_of(slab.front, corner), plane_of(slab.back, corner)};
  }

  /// Calls `paint` with the end of each part of the lanes' way that lies inside one cell, and the lanes that
  /// have it. `paint` should be inlined: calls of it take a tenth of a sum's time.
  HWY_INLINE void for_each_part(Walk& walk, F leave, M alive, auto&& paint) const {
    for (M on = both(alive, greater(leave, walk.w)); any(on); on = both(on, greater(leave, walk.w))) {
      const F end = max(min(leave, min(walk.u.next, walk.v.next)), walk.w);
      paint(end, both(on, greater(end, walk.w)));
      walk.go(end);
    }
  }

  /// Whether the voxels of the cells between ends are nothing to any lane. `enough`: as enough().
  HWY_INLINE bool cannot_change(const Projection& q, const SheetSlab& slab, F enough, M alive,
                                const Ends& ends) const {
    typename Base::ColumnRanges ranges;
    if (!this->find_ranges(slab, ends, ranges)) return false;
    if (q.mode == Mode::surface) return ranges.greatest() < q.isovalue || ranges.least() >= q.isovalue;
    if (!is_extremum(q)) return ranges.least() == q.zero && ranges.greatest() == q.zero;
    const float most = (q.sign > 0 ? ranges.greatest() : ranges.least()) - q.least;
    return least(choose(alive, enough, set(INFINITY))) >= most * q.sign;
  }

  HWY_INLINE CellOfLanes cell_of(const Walk& walk) const {
    const I u = walk.u.cell_in_box(p_.rays.voxels[0]), v = walk.v.cell_in_box(p_.rays.voxels[1]);
    return {u, v, Sampler::sheet(up<position_bits>(u), up<position_bits>(v), p_.pitch, walk.corner)};
  }
  HWY_INLINE CellPath path_of(const Walk& walk, const CellOfLanes& cell, F end) const {
    CellPath path{walk.u.place(walk.w, cell.u), walk.v.place(walk.w, cell.v), {}, {}};
    path.du = sub(walk.u.place(end, cell.u), path.u);
    path.dv = sub(walk.v.place(end, cell.v), path.v);
    return path;
  }
  /// front + w (back - front), where both are squares of s and w goes from walk.w to `end`.
  HWY_INLINE RayCubic values_on(const CellPath& path, const Walk& walk, F end, const auto& front,
                                const auto& back) const {
    const F length = sub(end, walk.w);
    const RayCubic a = path.values(front.corners()), b = path.values(back.corners());
    const F d0 = sub(b.f0, a.f0), d1 = sub(b.f1, a.f1), d2 = sub(b.f2, a.f2);
    return {fma(walk.w, d0, a.f0), fma(walk.w, d1, fma(length, d0, a.f1)),
            fma(walk.w, d2, fma(length, d1, a.f2)), mul(length, d2)};
  }

  /// How far a number is an extremum.
  static HWY_INLINE F beyond(const Projection& q, F number) {
    return mul(sub(number, set(q.least)), set(q.sign));
  }
  static HWY_INLINE F most_of(const Projection& q, const auto& front, const auto& back) {
    return beyond(q, q.sign > 0 ? greatest_of(front, back) : least_of(front, back));
  }
  static bool is_extremum(const Projection& q) {
    return q.mode == Mode::mip || q.mode == Mode::minip || dims(q);
  }
  static bool dims(const Projection& q) { return q.mode == Mode::attenuated; }

  /// Takes what is beyond `taken`.
  HWY_INLINE void take_extremum(const Projection& q, const Part& part, F& taken) const {
    const RayCubic& values = part.values;
    F found = max(beyond(q, values.f0), beyond(q, values.at(set(1.0F))));
    // The curve lies below the greatest of Bézier's points: often that is an end.
    const F third = set(1.0F / 3), one_third = fma(third, values.f1, values.f0),
            two_thirds = fma(third, add(values.f1, values.f2), one_third);
    const F bound = max(beyond(q, one_third), beyond(q, two_thirds));
    if (any(both(part.there, greater(bound, max(found, taken))))) {
      F first, second;
      values.turns(first, second);
      found = max(found, max(beyond(q, values.at(first)), beyond(q, values.at(second))));
    }
    // Rounding must not lift it above the voxels, by which tiles are left out. What is not a number stays so.
    found = min(part.most, found);
    taken = choose(both(part.there, greater(found, taken)), found, taken);
  }

  HWY_INLINE void take_integral(const Projection& q, const State& s, const Part& part, F& taken) const {
    const F value = mul(sub(part.values.integral(), set(q.zero)), set(q.unit));
    taken = choose(both(part.there, equal(value, value)), fma(value, length_of(s, part), taken), taken);
  }

  /// From slice to slice is 1.
  HWY_INLINE F length_of(const State& s, const Part& part) const {
    return mul(part.length(), mul(rays_.length(s.ray), set(slab_->face ? p_.face_pieces : 1.0F)));
  }

 private:
  void paint_tile(State& s) {
    M alive;
    bool by_planes = false;
    if (!begin_tile(s, alive, by_planes)) return;
    const Ends ends = rays_.ends(s.ray);
    const Corner corner = this->corner_below(ends);
    if (cannot_change(q_, *slab_, enough(s), alive, ends)) return;
    const Way way = way_of(s, ends, by_planes);
    const PlanePair planes = planes_of(*slab_, corner);
    Walk walk = walk_of(s, corner, way);
    if (q_.mode == Mode::surface) {
      // By the slice's own voxels, so that slabs on both sides agree.
      const F first = value_at(planes.front, rays_.at(s.ray, 0), corner),
              last = value_at(planes.back, rays_.at(s.ray, slab_->pieces), corner);
      walk.inside = above(first), walk.known = equal(first, first);
      walk.inside_last = above(last), walk.known_last = equal(last, last);
    }
    for_each_part(
        walk, way.leave, alive, [&](F end, M there) HWY_ATTR __attribute__((always_inline)) {
          paint_part(s, walk, planes, end, there);
        });
  }

  HWY_INLINE M above(F number) const {
    return but_not(equal(number, number), greater(set(q_.isovalue), number));
  }

  HWY_INLINE F value_at(const typename Sampler::Plane& plane, const Position& at, Corner corner) const {
    return Sampler::value(plane, this->sheet_in_box(at.u, at.v, corner), p_.pitch);
  }

  HWY_INLINE void paint_part(State& s, Walk& walk, const PlanePair& planes, F end, M there) const {
    const CellOfLanes cell = cell_of(walk);
    const auto front = Sampler::cell(planes.front, cell.sheet, p_.pitch),
               back = Sampler::cell(planes.back, cell.sheet, p_.pitch);
    F most = set(0.0F);
    if (is_extremum(q_)) {
      most = most_of(q_, front, back);
      if (!any(both(there, greater(most, enough(s))))) return;
    }
    const Part part{values_on(path_of(walk, cell, end), walk, end, front, back), walk.w, end, most, there};
    if (dims(q_)) {
      take_dimmed(s, part);
    } else if (is_extremum(q_)) {
      take_extremum(q_, part, s.red);
      s.opacity = choose(greater(set(q_.most), s.red), s.opacity, set(1.0F));
    } else if (q_.mode == Mode::surface) {
      find_surface(s, walk, planes, part);
    } else {
      take_integral(q_, s, part, s.red);
    }
  }

  /// Less far beyond, a number changes nothing.
  HWY_INLINE F enough(const State& s) const { return dims(q_) ? set(0.0F) : s.red; }

  /// Takes the most of what is left of numbers behind others. Between places an eighth of the part apart
  /// numbers are lines, and a peak of what is left a parabola.
  HWY_INLINE void take_dimmed(State& s, const Part& part) const {
    constexpr int pieces = 8;
    const F zero = set(0.0F), half = set(0.5F), most = set(q_.most),
            half_length = mul(set(0.5F / pieces * q_.unit), length_of(s, part));
    const auto left_at = [&](F depth) HWY_ATTR { return exp2_of(max(sub(zero, depth), set(-126.0F))); };
    // What is not a number is nothing.
    const auto shown = [&](F number) HWY_ATTR { return min(max(number, zero), most); };
    F number = beyond(q_, part.values.f0), depth = s.green, left = left_at(depth),
      here = mul(shown(number), left), found = max(s.red, here);
    F before = set(INFINITY);  // a part has no peak at its front
    for (int k = 1; k <= pieces; ++k) {
      const F next = beyond(q_, part.values.at(set(float(k) / pieces)));
      const F next_depth = fma(half_length, add(shown(number), shown(next)), depth),
              next_left = left_at(next_depth), there = mul(shown(next), next_left);
      const F rise = mul(half, sub(there, before)), bend = sub(add(here, here), add(before, there));
      const F peak = fma(mul(half, rise), div(rise, bend), here);
      const M at_peak = but_not(greater(bend, zero), either(greater(before, here), greater(there, here)));
      found = max(choose(at_peak, min(peak, mul(most, left)), there), max(there, found));
      // Where it reaches the most is a peak, too.
      const M reaches = but_not(greater(next, most), greater(number, most));
      const F way = div(sub(most, number), sub(next, number));
      const F reached = left_at(fma(mul(half_length, way), add(shown(number), most), depth));
      found = choose(reaches, max(mul(most, reached), found), found);
      number = next, depth = next_depth, left = next_left, before = here, here = there;
    }
    s.red = choose(part.there, found, s.red);
    s.green = choose(part.there, depth, s.green);
    s.opacity = choose(but_not(part.there, greater(mul(most, left), s.red)), set(1.0F), s.opacity);
  }

  /// Shows the surface where the field's side of its value changes first.
  HWY_INLINE void find_surface(State& s, Walk& walk, const PlanePair& planes, const Part& part) const {
    const F one = set(1.0F);
    F first, second, from = set(0.0F), to = from;
    part.values.turns(first, second);
    const M at_back = both(walk.known_last, equal(part.to, one));
    const F places[] = {first, second, one};
    // The slice's voxels say nothing of where a ray comes in through the box's side, or out of a hole.
    const M comes_in = both(greater(part.from, from), equal(part.from, walk.enter)),
            number = equal(part.values.f0, part.values.f0);
    walk.inside = choose_mask(but_not(walk.known, comes_in), walk.inside, above(part.values.f0));
    walk.known = choose_mask(part.there, number, walk.known);
    M found = greater(from, to), inside = walk.inside;
    for (int i = 0; i < 3; ++i) {
      M here = above(part.values.at(places[i]));
      if (i == 2) here = choose_mask(at_back, walk.inside_last, here);
      const M before = found;
      found = either(found, differs(here, inside));
      from = choose(found, from, places[i]);
      to = choose(but_not(found, before), places[i], to);
      inside = here;
    }
    found = both(found, both(part.there, number));
    if (any(found)) show_surface(s, walk, planes, part, crossing(part.values, from, to, walk.inside), found);
    walk.inside = choose_mask(part.there, inside, walk.inside);
  }

  /// Halves the way from a place `inside` tells the side of to one on the other side.
  HWY_INLINE F crossing(const RayCubic& values, F from, F to, M inside) const {
    return Base::first_place(from, to, 20,
                             [&](F at) HWY_ATTR { return differs(above(values.at(at)), inside); });
  }

  HWY_INLINE void show_surface(State& s, const Walk& walk, const PlanePair& planes, const Part& part, F at,
                               M found) const {
    const F w = fma(at, part.length(), part.from);
    if (q_.values) {
      found = but_not(found, greater(s.opacity, set(0.0F)));
      const float front = slab_->slice[0], back = slab_->slice[std::size_t(slab_->pieces)];
      s.red = choose(found, fma(set(back - front), w, set(front)), s.red);
      s.opacity = choose(found, set(1.0F), s.opacity);
      return;
    }
    Reflected light = Base::unlit();
    if (p_.lit) {
      const auto position = [&](const Along& along) HWY_ATTR {
        const F from_base = fma(along.way, w, along.from);
        return add(up<position_bits>(along.base), to_int(mul(from_base, set(float(one_voxel)))));
      };
      const auto sheet = this->sheet_in_box(position(walk.u), position(walk.v), walk.corner);
      const auto before = plane_of(slab_->before, walk.corner), after = plane_of(slab_->after, walk.corner);
      const Gradient front =
          Sampler::gradient(planes.front, (slab_->face ? after : planes.back) - before, sheet, p_.pitch);
      const Gradient back =
          Sampler::gradient(planes.back, after - (slab_->face ? before : planes.front), sheet, p_.pitch);
      light = this->lit_at(s, w, front, Base::difference(back, front));
    }
    const TableSlab surface{set(1.0F), set(q_.colour[0]), set(q_.colour[1]), set(q_.colour[2]), {}, {}};
    this->composite(s, surface, only(found, set(1.0F)), light);
  }

  static HWY_INLINE M differs(M a, M b) { return either(but_not(a, b), but_not(b, a)); }
  static HWY_INLINE M choose_mask(M m, M a, M b) { return either(both(m, a), but_not(b, m)); }

  const Projection& q_ = p_.projection;
};

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
