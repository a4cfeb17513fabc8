// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_TILE_PAINTER_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_TILE_PAINTER_INL
#undef RINGSPLAT_TILE_PAINTER_INL
#else
#define RINGSPLAT_TILE_PAINTER_INL
#endif

#include <algorithm>
#include <array>
#include <type_traits>

#include "sheet_engine/lanes-inl.hpp"
#include "sheet_engine/paint_group.hpp"
#include "sheet_engine/rays-inl.hpp"
#include "sheet_engine/samplers-inl.hpp"
#include "sheet_engine/slab_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// A tile's pixels while slabs are painted.
template <class Rays>
struct TilePixels {
  static constexpr bool has_more = false;  ///< of PixelGroup::more
  F red, green, blue, opacity;
  typename Rays::Tile ray;
  bool started = false, dead = false;
};

/// A group's tiles, row by row, their pixels in lanes, and where these lie in slices. `State` is a
/// TilePixels<Rays>, or more.
template <class Sampler, class Rays, class State>
class TilePainter {
 public:
  TilePainter(const SheetPaint& paint, const PixelGroup& group) : p_(paint), group_(group), rays_(paint) {}

  void store_pixels() {
    for (int t = 0; t < tiles; ++t) {
      const State& s = state_[t];
      if (!s.started) continue;
      const F rgba[] = {s.red, s.green, s.blue, s.opacity};
      store_pixels(t, rgba, group_.rgba);
      if constexpr (State::has_more)
        if (group_.more != nullptr) store_pixels(t, s.more, group_.more);
    }
  }

 protected:
  using Planes = typename Sampler::Plane;
  static constexpr int across = group_side / tile_width, tiles = across * (group_side / tile_height);

  /// A tile's bit in a TileMask.
  static int mask_bit(int t) {
    return (t / across) * tile_height / tile_side * (group_side / tile_side) +
           (t % across) * tile_width / tile_side;
  }

  /// Begins a slab: lists its tiles that still take something.
  void begin(const SheetSlab& slab, TileMask mask) {
    count_ = 0;
    for (int t = 0; t < tiles; ++t)
      if ((mask >> mask_bit(t) & 1) != 0 && !state_[t].dead) {
        if (!state_[t].started) start(t);
        list_[count_++] = t;
      }
    slab_ = &slab;
    if (count_ != 0) rays_.begin(slab);
  }

  /// Lanes that still take something.
  HWY_INLINE M alive(const State& s) const {
    return but_not(equal(s.opacity, s.opacity), greater(set(p_.opaque_threshold), sub(set(1.0F), s.opacity)));
  }

  std::int32_t most_u() const { return (p_.rays.voxels[0] - 1) << position_bits; }
  std::int32_t most_v() const { return (p_.rays.voxels[1] - 1) << position_bits; }
  Corner corner_below(const Ends& ends) const {
    return {(std::clamp(ends.low_u, 0, most_u()) >> position_bits) - 1,
            (std::clamp(ends.low_v, 0, most_v()) >> position_bits) - 1};
  }

  /// The least and the greatest numbers of a few columns of voxels.
  struct ColumnRanges {
    static constexpr int at_once = 8;
    using D = hn::CappedTag<std::int16_t, at_once>;
    hn::Vec<D> low, high;

    HWY_INLINE bool some_below(std::int16_t number) const {
      return !hn::AllFalse(D(), hn::Lt(low, hn::Set(D(), number)));
    }
    HWY_INLINE bool some_above(std::int16_t number) const {
      return !hn::AllFalse(D(), hn::Gt(high, hn::Set(D(), number)));
    }
    HWY_INLINE float least() const { return float(hn::GetLane(hn::MinOfLanes(D(), low))); }
    HWY_INLINE float greatest() const { return float(hn::GetLane(hn::MaxOfLanes(D(), high))); }
  };

  /// Of all voxels that lanes between these ends interpolate, in the slices before and behind the slab.
  /// Returns false where that says nothing or takes long: of floats, and of many columns or rows.
  HWY_INLINE bool find_ranges(const SheetSlab& slab, const Ends& ends, ColumnRanges& ranges) const {
    if constexpr (std::is_same_v<typename Sampler::Number, std::int16_t>) {
      const auto [u, columns] = voxels_between(ends.low_u, ends.high_u, p_.rays.voxels[0]);
      const auto [v, rows] = voxels_between(ends.low_v, ends.high_v, p_.rays.voxels[1]);
      if (columns > ColumnRanges::at_once || rows > ColumnRanges::at_once) return false;
      const typename ColumnRanges::D d;
      auto front = static_cast<const std::int16_t*>(slab.front) + v * p_.pitch + u,
           back = static_cast<const std::int16_t*>(slab.back) + v * p_.pitch + u;
      auto low = hn::LoadU(d, front), high = low;
      for (int row = 0; row < rows; ++row, front += p_.pitch, back += p_.pitch) {
        const auto a = hn::LoadU(d, front), b = hn::LoadU(d, back);
        low = hn::Min(low, hn::Min(a, b));
        high = hn::Max(high, hn::Max(a, b));
      }
      // What lies behind the last column counts as the first.
      const auto wanted = hn::FirstN(d, std::size_t(columns));
      ranges = {hn::IfThenElse(wanted, low, hn::Broadcast<0>(low)),
                hn::IfThenElse(wanted, high, hn::Broadcast<0>(high))};
      return true;
    }
    return false;
  }

  /// Where lanes at (u, v) lie. Beyond the outer voxels the field has their values.
  HWY_INLINE typename Sampler::Sheet sheet_in_box(I u, I v, Corner corner) const {
    return Sampler::sheet(min(max(u, set_int(0)), set_int(most_u())),
                          min(max(v, set_int(0)), set_int(most_v())), p_.pitch, corner);
  }

  /// Whether a lane may leave what is `beyond` the outer voxels' centres.
  bool leaves(const Ends& ends, std::int32_t beyond) const {
    return ends.low_u < -beyond || ends.low_v < -beyond || ends.high_u > most_u() + beyond ||
           ends.high_v > most_v() + beyond;
  }

  /// How far before a clip plane lanes at a position of sheet i are.
  HWY_INLINE F before(const SheetPlane& plane, const Position& at, int i) const {
    const F voxel = set(1.0F / one_voxel), slice = set(slab_->slice[std::size_t(i)]);
    const F in_slice = fma(set(plane.along[2]), slice, set(plane.offset));
    return fma(set(plane.along[0]), mul(voxel, to_float(at.u)),
               fma(set(plane.along[1]), mul(voxel, to_float(at.v)), in_slice));
  }
  /// Takes the lanes whose way through the slab is behind a clip plane from `seen`. Returns whether one may
  /// cut a lane's way; with a margin, so that no lane's bits depend on the others'.
  HWY_INLINE bool cut_by_planes(const State& s, M& seen) const {
    const int last = slab_->pieces;
    bool cut = false;
    for (int k = 0; k < p_.clip_plane_count; ++k) {
      const SheetPlane& plane = p_.clip_planes[std::size_t(k)];
      const F a = before(plane, rays_.at(s.ray, 0), 0), b = before(plane, rays_.at(s.ray, last), last);
      constexpr float margin = 0.0625F;
      cut = cut || any(greater(set(margin), min(a, b)));
      seen = but_not(seen, greater(set(0.0F), max(a, b)));
    }
    return cut;
  }

  /// The part of piece i that lies in the volume's box and before clip planes.
  HWY_INLINE Way way_in_box(const State& s, int i) const {
    const Position from = rays_.at(s.ray, i), to = rays_.at(s.ray, i + 1);
    Way way{set(0.0F), set(1.0F)};
    way.narrow(from.u, to.u, p_.rays.voxels[0]);
    way.narrow(from.v, to.v, p_.rays.voxels[1]);
    for (int k = 0; k < p_.clip_plane_count; ++k) {
      const SheetPlane& plane = p_.clip_planes[std::size_t(k)];
      way.limit(before(plane, from, i), before(plane, to, i + 1));
    }
    return way;
  }

  Planes plane_of(const void* origin, Corner corner) const {
    return Sampler::plane(origin, p_.pitch, corner);
  }

  static HWY_INLINE void composite(State& s, const TableSlab& slab, F opacity, const Reflected& light) {
    const F added = mul(sub(set(1.0F), s.opacity), opacity);
    const auto lit = [&](F colour)
                         HWY_ATTR { return min(fma(colour, light.scale, light.highlight), set(1.0F)); };
    s.red = fma(added, lit(slab.red), s.red);
    s.green = fma(added, lit(slab.green), s.green);
    s.blue = fma(added, lit(slab.blue), s.blue);
    s.opacity = add(s.opacity, added);
  }
  static HWY_INLINE Gradient difference(const Gradient& a, const Gradient& b) {
    return {sub(a.u, b.u), sub(a.v, b.v), sub(a.k, b.k)};
  }
  HWY_INLINE Reflected lit_at(const State& s, F way, const Gradient& front, const Gradient& change) const {
    return Reflect(p_.light, rays_.viewer(s.ray),
                   {fma(way, change.u, front.u), fma(way, change.v, front.v), fma(way, change.k, front.k)});
  }
  static Reflected unlit() { return {set(1.0F), set(0.0F), set(1.0F)}; }

  /// Halves the way from a place to one that lies `beyond` what is looked for, so often.
  static HWY_INLINE F first_place(F from, F to, int halvings, const auto& beyond) {
    for (int round = 0; round < halvings; ++round) {
      const F middle = mul(set(0.5F), add(from, to));
      const M here = beyond(middle);
      from = choose(here, from, middle);
      to = choose(here, middle, to);
    }
    return to;
  }

  const SheetPaint& p_;
  const PixelGroup& group_;
  Rays rays_;
  const SheetSlab* slab_ = nullptr;
  std::array<State, tiles> state_;
  std::array<int, tiles> list_;
  int count_ = 0;

 private:
  struct Voxels {
    int first, count;
  };
  /// Those at the corners of the cells between two positions.
  static HWY_INLINE Voxels voxels_between(std::int32_t low, std::int32_t high, int voxels) {
    const int last = voxels - 1, first = std::clamp(low >> position_bits, 0, std::max(last - 1, 0));
    return {first, std::clamp((high >> position_bits) + 1, first, last) - first + 1};
  }
  bool is_whole() const { return group_.width == group_side && group_.height == group_side; }
  float* pixel_of(int t, int lane, float* first) const {
    const int x = (t % across) * tile_width + lane % tile_width,
              y = (t / across) * tile_height + lane / tile_width;
    return x < group_.width && y < group_.height ? first + y * group_.row_floats + 4 * x : nullptr;
  }
  /// `first`: the group's first pixel, of four floats.
  void store_pixels(int t, const F (&four)[4], float* first) const {
    HWY_ALIGN float parts[4][lanes];
    for (int c = 0; c < 4; ++c) ringsplat::HWY_NAMESPACE::store(four[c], parts[c]);
    if (is_whole()) return store_rows(parts, pixel_of(t, 0, first), group_.row_floats);
    for (int l = 0; l < lanes; ++l)
      if (float* pixel = pixel_of(t, l, first))
        for (int c = 0; c < 4; ++c) pixel[c] = parts[c][l];
  }
  void load_pixels(int t, float* first, F (&four)[4]) const {
    HWY_ALIGN float parts[4][lanes];
    if (is_whole())
      load_rows(pixel_of(t, 0, first), group_.row_floats, parts);
    else
      for (int l = 0; l < lanes; ++l) {
        const float* pixel = pixel_of(t, l, first);
        for (int c = 0; c < 4; ++c) parts[c][l] = pixel != nullptr ? pixel[c] : 0.0F;
      }
    for (int c = 0; c < 4; ++c) four[c] = load(parts[c]);
  }

  void start(int t) {
    State& s = state_[t];
    s.started = true;
    s.ray = rays_.start(group_.x + (t % across) * tile_width, group_.y + (t / across) * tile_height);
    F rgba[4];
    load_pixels(t, group_.rgba, rgba);
    s.red = rgba[0];
    s.green = rgba[1];
    s.blue = rgba[2];
    s.opacity = rgba[3];
    if constexpr (State::has_more)
      if (group_.more != nullptr) load_pixels(t, group_.more, s.more);
  }
};

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
