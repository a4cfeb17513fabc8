#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sheet_engine/paint_group.cpp"
#include <hwy/foreach_target.h>

#include <cmath>

#include "sheet_engine/channel_painter-inl.hpp"
#include "sheet_engine/group_painter-inl.hpp"
#include "sheet_engine/paint_group.hpp"
#include "sheet_engine/projection_painter-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

template <class Painter>
void PaintBy(const SheetPaint& paint, const PixelGroup& group, const MaskedSlabs& slabs) {
  Painter painter(paint, group);
  for (std::size_t k = 0; k < slabs.slabs.size(); ++k)
    if (const TileMask mask = slabs.masks[std::ptrdiff_t(k) * slabs.stride]; mask != 0)
      painter.paint(slabs.slabs[k], mask);
  painter.store_pixels();
}

/// Calls `use` for the planes' numbers and the group's rays.
template <class Rays>
void WithSampler(const SheetPaint& paint, [[maybe_unused]] bool patches, const auto& use) {
  if (paint.floats) return use.template operator()<FloatSampler, Rays>();
#if RINGSPLAT_LANES_PATCHES
  if (patches) return use.template operator()<PatchSampler, Rays>();
#endif
  use.template operator()<PairSampler, Rays>();
}
void WithWays(const SheetPaint& paint, const PixelGroup& group, const auto& use) {
  if (const auto& eye = paint.rays.eye)
    WithSampler<EyeRays>(paint, eye->spans_less(group.x, group.y, group_side, tile_side, patch_span), use);
  else
    WithSampler<ParallelRays>(paint, paint.rays.patches, use);
}

void PaintGroup(const SheetPaint& paint, const PixelGroup& group, const MaskedSlabs& slabs) {
  WithWays(paint, group, [&]<class Sampler, class Rays>() {
    if (paint.projection.mode == Mode::composite)
      PaintBy<GroupPainter<Sampler, Rays>>(paint, group, slabs);
    else
      PaintBy<ProjectionPainter<Sampler, Rays>>(paint, group, slabs);
  });
}

void PaintChannels(std::span<const PaintedChannel> channels, std::size_t all, const PixelGroup& group) {
  WithWays(*channels.front().paint, group, [&]<class Sampler, class Rays>() {
    ChannelPainter<Sampler, Rays> painter(channels, all, group);
    for (std::size_t k = 0; k < channels.front().slabs.slabs.size(); ++k) painter.paint(k);
    painter.store_pixels();
  });
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(PaintGroup);
HWY_EXPORT(PaintChannels);

float place_of_number(const PlaceMap& map, float number) {
  if (map.even) return std::fma(number, map.scale, map.offset);
  float place = 0;
  for (int k = 0; k < map.count; ++k) {
    const auto& ramp = map.ramps[std::size_t(k)];
    place = std::fma(std::min(std::max(number - ramp.from, 0.0F), ramp.width), ramp.rise, place);
  }
  return place;
}

void paint_group(const SheetPaint& paint, const PixelGroup& group, const MaskedSlabs& slabs) {
  HWY_DYNAMIC_DISPATCH(PaintGroup)(paint, group, slabs);
}

void paint_channels(std::span<const PaintedChannel> channels, std::size_t all, const PixelGroup& group) {
  HWY_DYNAMIC_DISPATCH(PaintChannels)(channels, all, group);
}

}  // namespace ringsplat
#endif
