// Per-target include guard: Highway compiles this once for each instruction set.
#if defined(RINGSPLAT_CHANNEL_PAINTER_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef RINGSPLAT_CHANNEL_PAINTER_INL
#undef RINGSPLAT_CHANNEL_PAINTER_INL
#else
#define RINGSPLAT_CHANNEL_PAINTER_INL
#endif

#include <utility>

#include "sheet_engine/projection_painter-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

template <class Rays>
struct ChannelPixels : TilePixels<Rays> {
  static constexpr bool has_more = true;
  F more[4];

  HWY_INLINE F& value(int place) {
    F* const first[] = {&this->red, &this->green, &this->blue};
    return place < 3 ? *first[place] : more[place - 3];
  }
};

/// Takes the extrema or integrals of several channels. Rays' way through cells, which takes most of the time,
/// is found once for all of them.
template <class Sampler, class Rays>
class ChannelPainter : public ProjectionPainter<Sampler, Rays, ChannelPixels<Rays>> {
  using State = ChannelPixels<Rays>;
  using Base = ProjectionPainter<Sampler, Rays, State>;
  using Base::count_, Base::list_, Base::p_, Base::rays_, Base::state_;
  using typename Base::Part, typename Base::PlanePair, typename Base::Walk;

 public:
  ChannelPainter(std::span<const PaintedChannel> channels, std::size_t all, const PixelGroup& group)
      : Base(*channels.front().paint, group), channels_(channels), has_all_(channels.size() == all) {}

  /// Paints slab k.
  void paint(std::size_t k) {
    TileMask any_of = 0;
    for (std::size_t c = 0; c < channels_.size(); ++c)
      any_of |= masks_[c] = channels_[c].slabs.masks[std::ptrdiff_t(k) * channels_[c].slabs.stride];
    if (any_of == 0) return;
    this->begin(channels_.front().slabs.slabs[k], any_of);
    for (int i = 0; i < count_; ++i) paint_tile(list_[i], k);
  }

 private:
  /// A channel of which the tile's cells may change something.
  struct Active {
    const Projection* q;
    F* taken;
    PlanePair planes;
  };

  void paint_tile(int t, std::size_t k) {
    State& s = state_[t];
    M alive;
    bool by_planes = false;
    if (!this->begin_tile(s, alive, by_planes)) return;
    const Ends ends = rays_.ends(s.ray);
    const Corner corner = this->corner_below(ends);
    active_count_ = 0;
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      if ((masks_[c] >> Base::mask_bit(t) & 1) == 0) continue;
      const Projection& q = channels_[c].paint->projection;
      const SheetSlab& slab = channels_[c].slabs.slabs[k];
      F& taken = s.value(channels_[c].place);
      if (!this->cannot_change(q, slab, taken, alive, ends))
        active_[active_count_++] = {&q, &taken, this->planes_of(slab, corner)};
    }
    if (active_count_ == 0) return;
    const Way way = this->way_of(s, ends, by_planes);
    Walk walk = this->walk_of(s, corner, way);
    this->for_each_part(
        walk, way.leave, alive, [&](F end, M there) HWY_ATTR __attribute__((always_inline)) {
          paint_part(s, walk, end, there);
        });
    if (has_all_) note_done(s);
  }

  HWY_INLINE void paint_part(State& s, const Walk& walk, F end, M there) const {
    const auto cell = this->cell_of(walk);
    CellPath path;
    bool has_path = false;
    for (int c = 0; c < active_count_; ++c) {
      const auto& [q, taken, planes] = active_[c];
      const auto front = Sampler::cell(planes.front, cell.sheet, p_.pitch),
                 back = Sampler::cell(planes.back, cell.sheet, p_.pitch);
      const bool extremum = Base::is_extremum(*q);
      const F most = extremum ? Base::most_of(*q, front, back) : set(0.0F);
      if (extremum && !any(both(there, greater(most, *taken)))) continue;
      if (!std::exchange(has_path, true)) path = this->path_of(walk, cell, end);
      const Part part{this->values_on(path, walk, end, front, back), walk.w, end, most, there};
      if (extremum)
        this->take_extremum(*q, part, *taken);
      else
        this->take_integral(*q, s, part, *taken);
    }
  }

  HWY_INLINE void note_done(State& s) const {
    M done = equal(s.opacity, s.opacity);
    for (const PaintedChannel& channel : channels_) {
      const Projection& q = channel.paint->projection;
      if (!Base::is_extremum(q)) return;
      done = but_not(done, greater(set(q.most), s.value(channel.place)));
    }
    s.opacity = choose(done, set(1.0F), s.opacity);
  }

  std::span<const PaintedChannel> channels_;
  bool has_all_;  ///< the picture's
  std::array<TileMask, most_channels> masks_;
  std::array<Active, most_channels> active_;
  int active_count_ = 0;
};

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
