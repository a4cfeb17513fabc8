// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_SHEET_TILES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_SHEET_TILES_INL
#undef RINGSPLAT_SHEET_TILES_INL
#else
#define RINGSPLAT_SHEET_TILES_INL
#endif

#include <algorithm>
#include <array>

#include "sheet_engine/tile_painter-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

HWY_INLINE M known(F number) { return equal(number, number); }

/// Lanes' values, in planes' numbers, at the sheets from slice to slice. A slab counts as linear between two
/// ends. The field is not: along a ray it bends, and what it is on average above the line between two sheets
/// is added to both ends, as if it lay on a parabola through them and the next.
struct SheetNumbers {
  std::array<F, Traversal::most_slabs + 1> at;
  F low, high;

  HWY_INLINE F& operator[](int sheet) { return at[std::size_t(sheet)]; }
  HWY_INLINE const F& operator[](int sheet) const { return at[std::size_t(sheet)]; }

  /// What is not a number counts as less than all numbers.
  HWY_INLINE void find_range(int pieces, bool floats) {
    for (int i = 0; i <= pieces; ++i) {
      F number = (*this)[i];
      if (floats) number = choose(known(number), number, set(no_number));
      low = i == 0 ? number : min(low, number);
      high = i == 0 ? number : max(high, number);
    }
  }

  struct Ends {
    F front, back;
  };
  /// Of piece i, but never beyond the sheets' values, and as they are where one of these is not a number.
  HWY_INLINE Ends ends(int i, int pieces, bool floats) const {
    const F front = (*this)[i], back = (*this)[i + 1];
    if (pieces == 1) return {front, back};
    const int first = std::max(i, 1), last = std::min(i + 1, pieces - 1);
    F bulge = first == last ? mul(set(1.0F / 12), bend_at(first))
                            : mul(set(1.0F / 24), add(bend_at(first), bend_at(last)));
    if (floats) bulge = only(greater(low, set(no_number)), bulge);
    return {min(max(add(front, bulge), low), high), min(max(add(back, bulge), low), high)};
  }

  /// What all pieces are on average above the line between the slices.
  HWY_INLINE F whole_bulge(int pieces) const {
    const auto n = float(pieces);
    F sum = mul(set(-0.5F * (n - 1)), add((*this)[0], (*this)[pieces]));
    for (int i = 1; i < pieces; ++i) sum = add(sum, (*this)[i]);
    return mul(set(n / (n * n - 1)), sum);
  }

  /// How far they are at most beside that line, at a sheet.
  HWY_INLINE F bend(int pieces) const {
    if (pieces == 2) return mul(set(0.5F), abs(bend_at(1)));
    const F first = (*this)[0], step = mul(sub((*this)[pieces], first), set(1.0F / float(pieces)));
    F most = set(0.0F);
    for (int i = 1; i < pieces; ++i) most = max(most, abs(sub((*this)[i], fma(set(float(i)), step, first))));
    return most;
  }

 private:
  HWY_INLINE F bend_at(int sheet) const {
    const F here = (*this)[sheet];
    return sub(add(here, here), add((*this)[sheet - 1], (*this)[sheet + 1]));
  }
};

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

/// What a group's tiles read of a slab: values and gradients at its sheets.
template <class Sampler, class Rays>
class SheetTiles : public TilePainter<Sampler, Rays, SheetPixels<Rays>> {
  using Base = TilePainter<Sampler, Rays, SheetPixels<Rays>>;

 public:
  using Base::Base;

 protected:
  using State = SheetPixels<Rays>;
  using Base::count_, Base::list_, Base::p_, Base::rays_, Base::slab_, Base::state_;
  using Base::plane_of, Base::tiles;

  /// A tile in the current slab.
  struct Work {
    SheetNumbers numbers;
    std::array<typename Sampler::Sheet, Traversal::most_slabs + 1> sheet;  ///< from 1 on
    typename Sampler::Plane front, back;
    Corner corner;
    M visible, split;
    Entry whole;
    bool at_faces, cut;
  };

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
      const bool known = this->find_ranges(*slab_, rays_.ends(state_[t].ray), ranges);
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
      M seen = alive;
      const bool by_planes = this->cut_by_planes(s, seen);
      if (!any(seen)) continue;
      const Ends all = rays_.ends(s.ray);
      w.corner = this->corner_below(all);
      const bool some_miss = Rays::some_miss(s.ray);
      w.at_faces = some_miss || this->leaves(all, 0);
      w.cut = some_miss || by_planes || this->leaves(all, one_voxel / 2 - 1);
      w.front = Sampler::plane(slab_->front, p_.pitch, w.corner);
      w.back = Sampler::plane(slab_->back, p_.pitch, w.corner);
      for (int i = 1; i <= kind.pieces; ++i) w.sheet[std::size_t(i)] = sheet_at(s, w.at_faces, i, w.corner);
      w.visible = seen;
      if (!kind.nearest) {
        interpolate(kind, s, w);
        w.visible = both(seen, may_show(w));
      }
      list_[kept] = t;
      kept += any(w.visible) ? 1 : 0;
    }
    count_ = kept;
  }

  HWY_INLINE void interpolate(auto kind, State& s, Work& w) const {
    SheetNumbers& numbers = w.numbers;
    numbers[0] = s.sheet == slab_->step - 1
                     ? s.number
                     : Sampler::value(w.front, sheet_at(s, w.at_faces, 0, w.corner), p_.pitch);
    const int last = kind.pieces;
    for (int i = 1; i < last; ++i)
      numbers[i] = Sampler::value_between(w.front, w.back, w.sheet[std::size_t(i)], i, last, p_.pitch);
    numbers[last] = s.number = Sampler::value(w.back, w.sheet[std::size_t(last)], p_.pitch);
    s.sheet = slab_->step;
    numbers.find_range(last, p_.floats);
  }

  HWY_INLINE M may_show(const Work& w) const {
    const M shows = may_show(place_of(w.numbers.low), place_of(w.numbers.high));
    return p_.floats ? both(shows, greater(w.numbers.high, set(no_number))) : shows;
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

  using Gradients = std::array<Gradient, Traversal::most_slabs + 1>;
  HWY_INLINE void find_gradients(auto kind, State& s, const Work& w, Gradients& gradients) const {
    gradients[0] = front_gradient(kind, s, w);
    for (int i = 1; i <= kind.pieces; ++i) gradients[std::size_t(i)] = gradient_behind(kind, w, i);
    s.gradient = gradients[std::size_t(kind.pieces)];
    s.gradient_sheet = slab_->step;
  }

  std::array<Work, tiles> work_;

 private:
  int unasked_ = 0;  ///< slabs whose tiles are all taken
};

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
