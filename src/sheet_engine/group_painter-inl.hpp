// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_GROUP_PAINTER_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_GROUP_PAINTER_INL
#undef RINGSPLAT_GROUP_PAINTER_INL
#else
#define RINGSPLAT_GROUP_PAINTER_INL
#endif

#include <algorithm>
#include <array>

#include "sheet_engine/tile_painter-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// What painting a slab is compiled for: `n` pieces between two slices, of interpolated values,
template <int n>
struct Between {
  static constexpr int pieces = n;
  static constexpr bool face = false, nearest = false;
};
/// or whatever there is.
struct AnySlab {
  int pieces;
  bool face, nearest;
};

/// A tile's pixels, and what the last sheet leaves for the next slab.
template <class Rays>
struct SheetPixels : TilePixels<Rays> {
  static constexpr int none = -1 << 20;
  F number;                                 ///< at the last sheet
  Gradient gradient;                        ///< at the last sheet
  int sheet = none, gradient_sheet = none;  ///< the steps of these last sheets
};

/// Paints one group's pixels; see paint_group.hpp.
template <class Sampler, class Rays>
class GroupPainter : public TilePainter<Sampler, Rays, SheetPixels<Rays>> {
  using State = SheetPixels<Rays>;
  using Base = TilePainter<Sampler, Rays, State>;
  using Base::composite, Base::most_u, Base::most_v, Base::plane_of, Base::tiles, Base::unlit;
  using Base::count_, Base::list_, Base::p_, Base::rays_, Base::slab_, Base::state_;

 public:
  using Base::Base;

  void paint(const SheetSlab& slab, TileMask mask) {
    this->begin(slab, mask);
    if (!p_.floats && !p_.nearest) leave_out_transparent();
    if (count_ == 0) return;
    switch (slab.face || p_.nearest ? 0 : slab.pieces) {
      case 1:
        return paint_as(Between<1>());
      case 2:
        return paint_as(Between<2>());
      case 3:
        return paint_as(Between<3>());
      case 4:
        return paint_as(Between<4>());
      default:
        return paint_as(AnySlab{slab.pieces, slab.face, p_.nearest});
    }
  }

 private:
  /// A tile in the current slab.
  struct Work {
    std::array<F, Traversal::most_slabs + 1> number;
    std::array<typename Sampler::Sheet, Traversal::most_slabs + 1> sheet;  ///< from 1 on
    typename Sampler::Plane front, back;
    Corner corner;
    F low, high;  ///< of the numbers
    M visible, split;
    Entry whole;
    bool at_faces, cut;
  };

  void paint_as(auto kind) {
    resample(kind);
    if (count_ == 0) return;
    divide(kind);
    for (int k = 0; k < whole_count_; ++k) paint_whole(kind, whole_[k]);
    for (int k = 0; k < split_count_; ++k) paint_pieces(kind, split_[k]);
  }

  /// Leaves out tiles of which all voxels that are interpolated are transparent alike: blocks are much larger
  /// than a tile's cells. Inside what is visible it would find few, so after such a slab the next few are not
  /// asked.
  void leave_out_transparent() {
    if (unasked_ > 0) {
      --unasked_;
      return;
    }
    int kept = 0;
    for (int k = 0; k < count_; ++k) {
      const int t = list_[k];
      list_[kept] = t;
      typename Base::ColumnRanges ranges;
      const bool known = this->find_ranges(rays_.ends(state_[t].ray), ranges);
      kept += !known || numbers_may_show(ranges) ? 1 : 0;
    }
    constexpr int few = 8, next = 6;
    if (few * (count_ - kept) < count_) unasked_ = next;
    count_ = kept;
  }

  HWY_INLINE bool numbers_may_show(const typename Base::ColumnRanges& ranges) const {
    const PlaceMap& map = p_.places;
    bool shows = ranges.some_above(map.transparent.low) && ranges.some_below(map.transparent.high);
    for (int k = 0; k < map.gap_count; ++k) {
      const auto& gap = map.number_gaps[std::size_t(k)];
      shows = shows && (ranges.some_below(gap.low) || ranges.some_above(gap.high));
    }
    return shows;
  }

  /// Where the lanes lie in sheet i of the slab.
  HWY_INLINE typename Sampler::Sheet sheet_at(const State& s, bool at_faces, int i, Corner corner) const {
    const auto [u, v] = rays_.at(s.ray, i);
    return at_faces ? this->sheet_in_box(u, v, corner) : Sampler::sheet(u, v, p_.pitch, corner);
  }

  /// Places of values along the table's axes.
  HWY_INLINE F place_of(F number) const {
    const PlaceMap& map = p_.places;
    F place = set(0.0F);
    if (map.even) place = fma(number, set(map.scale), set(map.offset));
    for (int k = 0; !map.even && k < map.count; ++k) {
      const auto& ramp = map.ramps[std::size_t(k)];
      // Limits are second: a value that is not a number becomes one, and is found by itself.
      const F above = min(max(sub(number, set(ramp.from)), set(0.0F)), set(ramp.width));
      place = fma(above, set(ramp.rise), place);
    }
    if (p_.floats) place = choose(equal(number, number), place, set(no_place));
    return place;
  }

  /// Interpolates the values of all sheets; keeps in the list the tiles where something may be visible.
  void resample(auto kind) {
    const int pieces = kind.pieces;
    int kept = 0;
    for (int k = 0; k < count_; ++k) {
      const int t = list_[k];
      State& s = state_[t];
      Work& w = work_[t];
      const M alive = this->alive(s);
      if (!any(alive)) {
        s.dead = true;
        continue;
      }
      const Ends all = rays_.ends(s.ray);
      w.corner = this->corner_below(all);
      const bool some_miss = Rays::some_miss(s.ray);
      w.at_faces = some_miss || this->leaves(all, 0);
      w.cut = some_miss || this->leaves(all, one_voxel / 2 - 1);
      w.front = Sampler::plane(slab_->front, p_.pitch, w.corner);
      w.back = Sampler::plane(slab_->back, p_.pitch, w.corner);
      w.number[0] = kind.nearest                 ? voxel_number(kind, s, w, 0)
                    : s.sheet == slab_->step - 1 ? s.number
                                                 : front_number(s, w);
      for (int i = 1; i <= pieces; ++i) {
        w.sheet[std::size_t(i)] = sheet_at(s, w.at_faces, i, w.corner);
        w.number[std::size_t(i)] =
            kind.nearest ? voxel_number(kind, s, w, std::min(i, pieces - 1)) : sheet_number(kind, w, i);
      }
      find_range(kind, w);
      s.number = w.number[std::size_t(pieces)];
      s.sheet = slab_->step;
      w.visible = both(alive, may_show(w));
      list_[kept] = t;
      kept += any(w.visible) ? 1 : 0;
    }
    count_ = kept;
  }

  HWY_INLINE F front_number(const State& s, const Work& w) const {
    return Sampler::value(w.front, sheet_at(s, w.at_faces, 0, w.corner), p_.pitch);
  }

  HWY_INLINE F sheet_number(auto kind, const Work& w, int i) const {
    const auto& sheet = w.sheet[std::size_t(i)];
    return i == kind.pieces ? Sampler::value(w.back, sheet, p_.pitch)
                            : Sampler::value_between(w.front, w.back, sheet, i, kind.pieces, p_.pitch);
  }

  static HWY_INLINE M known(F number) { return equal(number, number); }

  /// What is not a number counts as less than all numbers.
  HWY_INLINE void find_range(auto kind, Work& w) const {
    for (int i = 0; i <= kind.pieces; ++i) {
      F number = w.number[std::size_t(i)];
      if (p_.floats) number = choose(known(number), number, set(no_number));
      w.low = i == 0 ? number : min(w.low, number);
      w.high = i == 0 ? number : max(w.high, number);
    }
  }

  /// What the values between two sheets are on average above the line between their ends, if they lie on a
  /// parabola: a twelfth of its second difference, which is that at the sheets beside them.
  HWY_INLINE F bulge(auto kind, const Work& w, int i) const {
    const auto bend = [&](int j) HWY_ATTR {
      const F here = w.number[std::size_t(j)];
      return sub(add(here, here), add(w.number[std::size_t(j - 1)], w.number[std::size_t(j + 1)]));
    };
    const int first = std::max(i, 1), last = std::min(i + 1, kind.pieces - 1);
    const F bulge =
        first == last ? mul(set(1.0F / 12), bend(first)) : mul(set(1.0F / 24), add(bend(first), bend(last)));
    return p_.floats ? only(greater(w.low, set(no_number)), bulge) : bulge;
  }

  /// Of the voxel that is nearest to the middle of piece i; of two the one with the greater number, although
  /// positions are rounded down.
  HWY_NOINLINE F voxel_number(auto kind, const State& s, const Work& w, int i) const {
    const Position from = rays_.at(s.ray, i), to = rays_.at(s.ray, i + 1);
    constexpr std::int32_t rounding = 1;
    const auto nearest = [&](I a, I b, std::int32_t most) HWY_ATTR {
      const I middle = add(a, down_signed<1>(sub(b, a)));
      return add(min(max(middle, set_int(0)), set_int(most)), set_int(one_voxel / 2 + rounding));
    };
    const auto sheet =
        Sampler::sheet(nearest(from.u, to.u, most_u()), nearest(from.v, to.v, most_v()), p_.pitch, w.corner);
    return Sampler::voxel(2 * i < kind.pieces ? w.front : w.back, sheet);
  }

  HWY_INLINE M may_show(const Work& w) const {
    const M shows = may_show(place_of(w.low), place_of(w.high));
    return p_.floats ? both(shows, greater(w.high, set(no_number))) : shows;
  }
  HWY_INLINE M may_show(F low, F high) const {
    const PlaceMap& map = p_.places;
    M shows = both(greater(high, set(map.visible_low)), greater(set(map.visible_high), low));
    for (int k = 0; k < map.gap_count; ++k) {
      const auto& gap = map.gaps[std::size_t(k)];
      // Not (gap.low <= low and high <= gap.high).
      shows = both(shows, either(greater(set(gap.low), low), greater(high, set(gap.high))));
    }
    return shows;
  }

  HWY_INLINE I entry_of(F place) const { return to_int(min(max(place, set(0.0F)), set(p_.last_entry))); }

  /// Finds the lanes that a single slab serves: its opacity, and what the value half-way may change of it,
  /// are small. Divides the tiles into those where it serves all and others.
  void divide(auto kind) {
    whole_count_ = split_count_ = 0;
    const bool may_be_whole = p_.adaptive && kind.pieces > 1 && !kind.face && p_.places.even &&
                              p_.depths == nullptr && !kind.nearest;
    for (int k = 0; k < count_; ++k) {
      const int t = list_[k];
      const State& s = state_[t];
      Work& w = work_[t];
      w.split = w.visible;
      if (may_be_whole) {
        w.whole = Look(p_.table, entry_of(place_of(w.number[0])),
                       entry_of(place_of(w.number[std::size_t(kind.pieces)])));
        w.split = but_not(w.visible, single_slab_serves(kind, s, w));
      }
      if (any(w.split))
        split_[split_count_++] = t;
      else
        whole_[whole_count_++] = t;
    }
  }

  HWY_INLINE M single_slab_serves(auto kind, const State& s, const Work& w) const {
    // The more slabs, the smaller is the error that one instead of them may add to.
    const float pieces = float(kind.pieces), most_opacity = 0.07F / pieces, most_change = 0.024F / pieces;
    constexpr float most_entries = 8;
    const F opacity = of_all_pieces(kind, OpacityOf(w.whole)), through = sub(set(1.0F), s.opacity),
            bend = bend_of(kind, w);
    const F over_steepness = from_bits(sub(set_int((127 + 15) << 23), up<23>(down<28>(w.whole.high))));
    M serves = both(both(greater(set(most_opacity), mul(through, opacity)),
                         greater(mul(set(most_change), over_steepness), mul(through, bend))),
                    greater(set(most_entries), bend));
    if (w.cut)
      for (int i = 0; i <= kind.pieces; ++i) serves = both(serves, in_box(s, i));
    return serves;
  }

  /// How far the values between the slices are from a straight line, in table entries.
  HWY_INLINE F bend_of(auto kind, const Work& w) const {
    const int pieces = kind.pieces;
    const float entries = p_.places.scale;
    if (pieces == 2)
      return mul(set(0.5F * entries), abs(sub(add(w.number[1], w.number[1]), add(w.number[0], w.number[2]))));
    const F first = w.number[0],
            step = mul(sub(w.number[std::size_t(pieces)], first), set(1.0F / float(pieces)));
    F most = set(0.0F);
    for (int i = 1; i < pieces; ++i)
      most = max(most, abs(sub(w.number[std::size_t(i)], fma(set(float(i)), step, first))));
    return mul(most, set(entries));
  }

  HWY_INLINE M in_box(const State& s, int i) const {
    constexpr std::int32_t half = one_voxel / 2;
    const auto [u, v] = rays_.at(s.ray, i);
    return both(both(greater(u, set_int(-half - 1)), greater(set_int(most_u() + half), u)),
                both(greater(v, set_int(-half - 1)), greater(set_int(most_v() + half), v)));
  }

  HWY_INLINE Gradient front_gradient(auto kind, const State& s, const Work& w) const {
    if (s.gradient_sheet == slab_->step - 1) return s.gradient;
    const auto next = kind.face ? plane_of(slab_->after, w.corner) : w.back;
    return Sampler::gradient(w.front, next - plane_of(slab_->before, w.corner),
                             sheet_at(s, w.at_faces, 0, w.corner), p_.pitch);
  }
  HWY_INLINE Gradient gradient_behind(auto kind, const Work& w, int i) const {
    const auto after = plane_of(slab_->after, w.corner);
    const auto& sheet = w.sheet[std::size_t(i)];
    if (i < kind.pieces && !kind.face)
      return Sampler::gradient_between(plane_of(slab_->before, w.corner), w.front, w.back, after, sheet, i,
                                       kind.pieces, p_.pitch);
    const auto last = kind.face ? plane_of(slab_->before, w.corner) : w.front;
    return Sampler::gradient(w.back, after - last, sheet, p_.pitch);
  }

  static HWY_INLINE Gradient difference(const Gradient& a, const Gradient& b) {
    return {sub(a.u, b.u), sub(a.v, b.v), sub(a.k, b.k)};
  }
  HWY_INLINE Reflected lit_at(const State& s, F way, const Gradient& front, const Gradient& change) const {
    return Reflect(p_.light, rays_.viewer(s.ray),
                   {fma(way, change.u, front.u), fma(way, change.v, front.v), fma(way, change.k, front.k)});
  }

  /// The opacity of as many of the table's slabs as there are from slice to slice.
  HWY_INLINE F of_all_pieces(auto kind, F piece) const {
    F opacity = mul(piece, sub(set(2.0F), piece));
    for (int i = 2; i < kind.pieces; ++i) opacity = fma(piece, sub(set(1.0F), opacity), opacity);
    return opacity;
  }
  HWY_INLINE F whole_opacity(auto kind, const State& s, const TableSlab& slab) const {
    const F opacity = of_all_pieces(kind, slab.opacity);
    return Rays::same_lengths ? opacity : Shortened(opacity, rays_.length(s.ray));
  }

  /// One slab for all visible lanes, lit at its centroid.
  HWY_INLINE void paint_whole(auto kind, int t) {
    State& s = state_[t];
    const Work& w = work_[t];
    const TableSlab slab = Unpack(w.whole);
    Reflected light = unlit();
    if (p_.lit) {
      const Gradient back = gradient_behind(kind, w, kind.pieces), front = front_gradient(kind, s, w);
      s.gradient = back;
      s.gradient_sheet = slab_->step;
      light = lit_at(s, slab.centroid, front, difference(back, front));
    }
    composite(s, slab, only(w.visible, whole_opacity(kind, s, slab)), light);
  }

  /// The slab's pieces one by one; lanes that a single slab serves take it in place of the first.
  HWY_INLINE void paint_pieces(auto kind, int t) {
    State& s = state_[t];
    const Work& w = work_[t];
    const int pieces = kind.pieces;
    const bool is_lit = p_.lit;
    std::array<Gradient, Traversal::most_slabs + 1> gradients;
    if (is_lit) {
      gradients[0] = front_gradient(kind, s, w);
      for (int i = 1; i <= pieces; ++i) gradients[std::size_t(i)] = gradient_behind(kind, w, i);
      s.gradient = gradients[std::size_t(pieces)];
      s.gradient_sheet = slab_->step;
    }
    for (int i = 0; i < pieces; ++i) {
      const auto front = std::size_t(i), back = front + 1;
      const bool may_be_whole = i == 0 && pieces > 1 && !kind.face && !kind.nearest;
      M here = i == 0 ? w.visible : w.split;
      F begin = w.number[front], end = w.number[kind.nearest ? front : back];
      if (pieces > 1 && !kind.face && !kind.nearest) {
        const F more = bulge(kind, w, i);
        begin = min(max(add(begin, more), w.low), w.high);
        end = min(max(add(end, more), w.low), w.high);
      }
      begin = place_of(begin);
      end = place_of(end);
      if (kind.nearest) here = both(here, may_show(begin, begin));
      if (may_be_whole) {
        begin = choose(w.split, begin, place_of(w.number[0]));
        end = choose(w.split, end, place_of(w.number[std::size_t(pieces)]));
      }
      // A ValueTable is one row.
      const I row = kind.nearest ? set_int(0) : entry_of(begin);
      const TableSlab slab = Unpack(Look(p_.table, row, entry_of(end)));
      F opacity = p_.depths == nullptr ? slab.opacity : OpacityBetween(p_, begin, end);
      if (!Rays::same_lengths || w.cut || kind.face)
        opacity = Shortened(opacity, length_in_box(kind, s, w, i));
      if (may_be_whole) opacity = choose(w.split, opacity, whole_opacity(kind, s, slab));
      opacity = only(here, opacity);
      if (p_.floats) opacity = only(both(known(w.number[front]), known(w.number[back])), opacity);
      Reflected light = unlit();
      if (is_lit) {
        Gradient change = difference(gradients[back], gradients[front]);
        if (may_be_whole) {
          const Gradient over_all = difference(gradients[std::size_t(pieces)], gradients[0]);
          change = {choose(w.split, change.u, over_all.u), choose(w.split, change.v, over_all.v),
                    choose(w.split, change.k, over_all.k)};
        }
        light = lit(s, w, slab, opacity, gradients[front], change);
      }
      composite(s, slab, opacity, light);
    }
  }

  /// Lit at the slab's centroid, or where it shows at centroid - spread and centroid + spread.
  HWY_INLINE Reflected lit(const State& s, const Work& w, const TableSlab& slab, F opacity,
                           const Gradient& front, const Gradient& change) const {
    M two = w.split;
    constexpr float worth_two = 0.02F;
    if (p_.adaptive) two = both(two, greater(mul(sub(set(1.0F), s.opacity), opacity), set(worth_two)));
    if (p_.light_points == 1 || !any(two)) return lit_at(s, slab.centroid, front, change);
    // Lanes of one point have it twice: half the sum of equal numbers is that number.
    const F spread = only(two, slab.spread), half = set(0.5F);
    const Reflected a = lit_at(s, max(sub(slab.centroid, spread), set(0.0F)), front, change),
                    b = lit_at(s, min(add(slab.centroid, spread), set(1.0F)), front, change);
    return {mul(half, add(a.scale, b.scale)), mul(half, add(a.highlight, b.highlight))};
  }

  /// The length of the part of piece i that lies in the volume's box, in the table's lengths.
  HWY_INLINE F length_in_box(auto kind, const State& s, const Work& w, int i) const {
    const float pieces = kind.face ? p_.face_pieces / float(kind.pieces) : 1.0F;
    const F length = mul(rays_.length(s.ray), set(pieces));
    if (!w.cut) return length;
    return mul(length, this->way_in_box(s, i).length());
  }

  std::array<Work, tiles> work_;
  std::array<int, tiles> whole_, split_;
  int whole_count_ = 0, split_count_ = 0;
  int unasked_ = 0;  ///< slabs whose tiles are all taken
};

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
