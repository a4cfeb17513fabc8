// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_GROUP_PAINTER_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_GROUP_PAINTER_INL
#undef RINGSPLAT_GROUP_PAINTER_INL
#else
#define RINGSPLAT_GROUP_PAINTER_INL
#endif

#include <array>

#include "sheet_engine/sheet_tiles-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// The voxels nearest to lanes on their way from a sheet to another within half a slice, so that they meet
/// at most two along u and two along v. Beyond the outer voxels' centres those are the nearest.
class VoxelsOnWay {
 public:
  static constexpr int most = 3;

  HWY_INLINE VoxelsOnWay(const Position& from, const Position& to, std::int32_t most_u, std::int32_t most_v) {
    const Steps u(from.u, to.u, most_u), v(from.v, to.v, most_v);
    const M u_first = greater(v.crossing, u.crossing);
    at_[0] = {u.first, v.first};
    at_[1] = {choose(u_first, u.last, u.first), choose(u_first, v.first, v.last)};
    at_[2] = {u.last, v.last};
    end_[0] = min(u.crossing, v.crossing);
    end_[1] = max(u.crossing, v.crossing);
    end_[2] = set(1.0F);
  }

  /// What the lane with most voxels has.
  HWY_INLINE int count() const {
    return any(greater(end_[2], end_[1])) ? 3 : any(greater(end_[2], end_[0])) ? 2 : 1;
  }
  HWY_INLINE const Position& at(int k) const { return at_[k]; }
  /// Shares of the way; voxels that a lane does not have end where they begin.
  HWY_INLINE F begin(int k) const { return k == 0 ? set(0.0F) : end_[k - 1]; }
  HWY_INLINE F end(int k) const { return end_[k]; }

  /// Takes voxels of equal numbers for one; `numbers` has those of count() voxels.
  HWY_INLINE void join(const F* numbers) {
    const int n = count();
    if (n == 3) end_[1] = choose(equal(numbers[1], numbers[2]), end_[2], end_[1]);
    if (n > 1) end_[0] = choose(equal(numbers[0], numbers[1]), end_[1], end_[0]);
  }

 private:
  /// Along one axis: the voxels at both ends, and the share of the way to the face between them.
  struct Steps {
    I first, last;
    F crossing;

    HWY_INLINE Steps(I from, I to, std::int32_t most) {
      const I a = NearestVoxel(from, most), b = NearestVoxel(to, most);
      const I face = sub(up<position_bits>(max(a, min(b, add(a, set_int(1))))), set_int(before_voxel));
      const M crosses = either(greater(a, b), greater(b, a));
      const F way = choose(crosses, to_float(sub(to, from)), set(1.0F));
      crossing =
          choose(crosses, min(max(div(to_float(sub(face, from)), way), set(0.0F)), set(1.0F)), set(1.0F));
      first = up<position_bits>(a);
      last = up<position_bits>(b);
    }
  };

  Position at_[most];
  F end_[most];
};

/// Paints one group's pixels; see paint_group.hpp.
template <class Sampler, class Rays>
class GroupPainter : public SheetTiles<Sampler, Rays> {
  using Base = SheetTiles<Sampler, Rays>;
  using State = SheetPixels<Rays>;
  using Base::composite, Base::difference, Base::entry_of, Base::find_gradients, Base::front_gradient,
      Base::gradient_behind, Base::lit_at, Base::may_show, Base::most_u, Base::most_v, Base::place_of,
      Base::tiles, Base::unlit;
  using Base::count_, Base::list_, Base::p_, Base::rays_, Base::slab_, Base::state_, Base::work_;
  using typename Base::Gradients, typename Base::Work;

 public:
  using Base::Base;

  void paint(const SheetSlab& slab, TileMask mask) {
    this->begin(slab, mask);
    if (!p_.floats && !p_.nearest) this->leave_out_transparent();
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
  void paint_as(auto kind) {
    this->resample(kind);
    if (count_ == 0) return;
    if (kind.nearest) {
      for (int k = 0; k < count_; ++k) paint_voxels(kind, list_[k]);
      return;
    }
    divide(kind);
    for (int k = 0; k < whole_count_; ++k) paint_whole(kind, whole_[k]);
    for (int k = 0; k < split_count_; ++k) paint_pieces(kind, split_[k]);
  }

  /// Finds the lanes that a single slab serves: its opacity, and what the value half-way may change of it,
  /// are small. Divides the tiles into those where it serves all and others.
  void divide(auto kind) {
    whole_count_ = split_count_ = 0;
    some_whole_ = p_.adaptive && kind.pieces > 1 && !kind.face && p_.places.even && p_.depths == nullptr;
    for (int k = 0; k < count_; ++k) {
      const int t = list_[k];
      const State& s = state_[t];
      Work& w = work_[t];
      w.split = w.visible;
      if (some_whole_) {
        const F bulge = w.numbers.whole_bulge(kind.pieces);
        w.whole = Look(p_.table, entry_of(place_of(add(w.numbers[0], bulge))),
                       entry_of(place_of(add(w.numbers[kind.pieces], bulge))));
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
            bend = mul(set(p_.places.scale), w.numbers.bend(kind.pieces));
    const F over_steepness = from_bits(sub(set_int((127 + 15) << 23), up<23>(down<28>(w.whole.high))));
    M serves = both(both(greater(set(most_opacity), mul(through, opacity)),
                         greater(mul(set(most_change), over_steepness), mul(through, bend))),
                    greater(set(most_entries), bend));
    if (w.cut)
      for (int i = 0; i <= kind.pieces; ++i) serves = both(serves, in_box(s, i));
    return serves;
  }

  HWY_INLINE M in_box(const State& s, int i) const {
    constexpr std::int32_t half = one_voxel / 2;
    const auto [u, v] = rays_.at(s.ray, i);
    M in = both(both(greater(u, set_int(-half - 1)), greater(set_int(most_u() + half), u)),
                both(greater(v, set_int(-half - 1)), greater(set_int(most_v() + half), v)));
    for (int k = 0; k < p_.clip_plane_count; ++k)
      in = but_not(in, greater(set(0.0F), this->before(p_.clip_planes[std::size_t(k)], {u, v}, i)));
    return in;
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
    TableSlab slab = Unpack(w.whole);
    if (p_.tints != nullptr) slab = tinted(slab, slab_->front_labels, middle(s, 0, kind.pieces));
    Reflected light = unlit();
    if (p_.lit) {
      const Gradient back = gradient_behind(kind, w, kind.pieces), front = front_gradient(kind, s, w);
      s.gradient = back;
      s.gradient_sheet = slab_->step;
      light = lit_at(s, slab.centroid, front, difference(back, front));
    }
    composite(s, slab, at_edges(only(w.visible, whole_opacity(kind, s, slab)), light), light);
  }

  /// The slab's pieces one by one; lanes that a single slab serves take it in place of the first.
  HWY_INLINE void paint_pieces(auto kind, int t) {
    State& s = state_[t];
    const Work& w = work_[t];
    const int pieces = kind.pieces;
    const bool is_lit = p_.lit, some_whole = pieces > 1 && !kind.face && some_whole_;
    Gradients gradients;
    if (is_lit) find_gradients(kind, s, w, gradients);
    for (int i = 0; i < pieces; ++i) {
      const auto front = std::size_t(i), back = front + 1;
      const bool may_be_whole = i == 0 && some_whole;
      const M here = i == 0 ? w.visible : w.split;
      const SheetNumbers& numbers = w.numbers;
      const auto ends = numbers.ends(i, kind.face ? 1 : pieces, p_.floats);
      const F begin = place_of(ends.front), end = place_of(ends.back);
      Entry entry = Look(p_.table, entry_of(begin), entry_of(end));
      if (may_be_whole)
        entry = {choose(w.split, entry.low, w.whole.low), choose(w.split, entry.high, w.whole.high)};
      TableSlab slab = Unpack(entry);
      if (p_.tints != nullptr) {
        Position at = middle(s, i, i + 1);
        if (may_be_whole) {
          const Position of_all = middle(s, 0, pieces);
          at = {choose(w.split, at.u, of_all.u), choose(w.split, at.v, of_all.v)};
        }
        slab = tinted(slab, 2 * i < pieces ? slab_->front_labels : slab_->back_labels, at);
      }
      F opacity = p_.depths == nullptr ? slab.opacity : OpacityBetween(p_, begin, end);
      if (!Rays::same_lengths || w.cut || kind.face)
        opacity = Shortened(opacity, length_in_box(kind, s, w, i));
      if (may_be_whole) opacity = choose(w.split, opacity, whole_opacity(kind, s, slab));
      opacity = only(here, opacity);
      if (p_.floats) opacity = only(both(known(numbers[i]), known(numbers[i + 1])), opacity);
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
      if (p_.projection.values)
        find_depth(kind, s, w, i, ends.front, ends.back, at_edges(opacity, light), light);
      else
        composite(s, slab, at_edges(opacity, light), light);
    }
  }

  /// The pieces' nearest voxels. A piece is cut where a lane's ray goes on to the next voxel.
  void paint_voxels(auto kind, int t) {
    State& s = state_[t];
    Work& w = work_[t];
    w.split = w.visible;
    Gradients gradients;
    bool has_gradients = false;
    for (int i = 0; i < kind.pieces; ++i) {
      const auto front = std::size_t(i), back = front + 1;
      VoxelsOnWay voxels(rays_.at(s.ray, i), rays_.at(s.ray, i + 1), most_u(), most_v());
      const Way way = w.cut ? this->way_in_box(s, i) : Way{set(0.0F), set(1.0F)};
      const auto& plane = 2 * i < kind.pieces ? w.front : w.back;
      F numbers[VoxelsOnWay::most];
      for (int k = 0; k < voxels.count(); ++k)
        numbers[k] =
            Sampler::voxel(plane, Sampler::sheet(voxels.at(k).u, voxels.at(k).v, p_.pitch, w.corner));
      if (p_.tints == nullptr) voxels.join(numbers);
      for (int k = 0, count = voxels.count(); k < count; ++k) {
        const F place = place_of(numbers[k]), from = max(way.enter, voxels.begin(k)),
                part = sub(min(way.leave, voxels.end(k)), from);
        const M here = both(both(w.visible, may_show(place, place)), greater(part, set(0.0F)));
        if (!any(here)) continue;
        // A ValueTable is one row.
        TableSlab slab = Unpack(Look(p_.table, set_int(0), entry_of(place)));
        if (p_.tints != nullptr)
          slab = tinted(slab, 2 * i < kind.pieces ? slab_->front_labels : slab_->back_labels, voxels.at(k));
        F opacity = slab.opacity;
        if (!Rays::same_lengths || w.cut || kind.face || count > 1)
          opacity = Shortened(opacity, mul(piece_length(kind, s), part));
        opacity = only(here, opacity);
        Reflected light = unlit();
        if (p_.lit) {
          if (!has_gradients) find_gradients(kind, s, w, gradients);
          has_gradients = true;
          slab.centroid = fma(part, slab.centroid, from);
          slab.spread = mul(part, slab.spread);
          light = lit(s, w, slab, opacity, gradients[front], difference(gradients[back], gradients[front]));
        }
        if (p_.projection.values)
          keep_depth(s, i, from, part, at_edges(opacity, light),
                     [&](F share) HWY_ATTR { return at_edges(Shortened(opacity, share), light); });
        else
          composite(s, slab, at_edges(opacity, light), light);
      }
    }
  }

  /// Piece i, whose numbers go from `front` to `back`, is `opacity` in all.
  HWY_NOINLINE void find_depth(auto kind, State& s, const Work& w, int i, F front, F back, F opacity,
                               const Reflected& light) const {
    const Way way = w.cut ? this->way_in_box(s, i) : Way{set(0.0F), set(1.0F)};
    const F length = length_in_box(kind, s, w, i), begin = place_of(front);
    keep_depth(s, i, way.enter, way.length(), opacity, [&](F share) HWY_ATTR {
      const F place = place_of(fma(share, sub(back, front), front));
      const F before = p_.depths == nullptr ? OpacityOf(Look(p_.table, entry_of(begin), entry_of(place)))
                                            : OpacityBetween(p_, begin, place);
      return at_edges(Shortened(before, mul(share, length)), light);
    });
  }

  /// Composites the `part` of piece i behind the share `from` of it, and keeps in red the slice, from the
  /// middle one, where its opacity exceeds Projection::opacity. Then the pixel is opaque.
  /// `opacity_before`: what lies before a share of that part.
  HWY_INLINE void keep_depth(State& s, int i, F from, F part, F opacity, const auto& opacity_before) const {
    const F one = set(1.0F), before = s.opacity, wanted = set(p_.projection.opacity);
    const auto with = [&](F more) HWY_ATTR { return fma(sub(one, before), more, before); };
    const F behind = with(opacity);
    const M here = but_not(greater(behind, wanted), greater(before, wanted));
    s.opacity = choose(here, one, behind);
    if (!any(here)) return;
    const F share = Base::first_place(
        set(0.0F), one, 12, [&](F at) HWY_ATTR { return greater(with(opacity_before(at)), wanted); });
    const float front = slab_->slice[std::size_t(i)], back = slab_->slice[std::size_t(i) + 1];
    s.red = choose(here, fma(set(back - front), fma(share, part, from), set(front)), s.red);
  }

  /// Half-way between two sheets.
  HWY_INLINE Position middle(const State& s, int first, int last) const {
    const Position a = rays_.at(s.ray, first), b = rays_.at(s.ray, last);
    return {add(a.u, down_signed<1>(sub(b.u, a.u))), add(a.v, down_signed<1>(sub(b.v, a.v)))};
  }
  TableSlab tinted(const TableSlab& slab, const std::uint8_t* labels, const Position& at) const {
    return Tinted(p_, slab, labels, at.u, at.v);
  }

  HWY_INLINE F at_edges(F opacity, const Reflected& light) const {
    return p_.light.edges ? Shortened(opacity, light.opaque) : opacity;
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
    return {mul(half, add(a.scale, b.scale)), mul(half, add(a.highlight, b.highlight)),
            mul(half, add(a.opaque, b.opaque))};
  }

  /// The length of the part of piece i that lies in the volume's box, in the table's lengths.
  HWY_INLINE F length_in_box(auto kind, const State& s, const Work& w, int i) const {
    const F length = piece_length(kind, s);
    return w.cut ? mul(length, this->way_in_box(s, i).length()) : length;
  }
  HWY_INLINE F piece_length(auto kind, const State& s) const {
    return mul(rays_.length(s.ray), set(kind.face ? p_.face_pieces / float(kind.pieces) : 1.0F));
  }

  std::array<int, tiles> whole_, split_;
  int whole_count_ = 0, split_count_ = 0;
  bool some_whole_ = false;  ///< tiles of the slab have been asked for lanes that a single slab serves
};

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
