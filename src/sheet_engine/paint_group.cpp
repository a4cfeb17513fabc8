#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sheet_engine/paint_group.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <cmath>

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

template <class Sampler, class Rays>
void PaintWith(const SheetPaint& paint, const PixelGroup& group, const MaskedSlabs& slabs) {
  if (paint.projection.mode == Mode::composite)
    PaintBy<GroupPainter<Sampler, Rays>>(paint, group, slabs);
  else
    PaintBy<ProjectionPainter<Sampler, Rays>>(paint, group, slabs);
}

template <class Rays>
void PaintAlong(const SheetPaint& paint, const PixelGroup& group, const MaskedSlabs& slabs,
                [[maybe_unused]] bool patches) {
  if (paint.floats) return PaintWith<FloatSampler, Rays>(paint, group, slabs);
#if RINGSPLAT_LANES_PATCHES
  if (patches) return PaintWith<PatchSampler, Rays>(paint, group, slabs);
#endif
  PaintWith<PairSampler, Rays>(paint, group, slabs);
}

void PaintGroup(const SheetPaint& paint, const PixelGroup& group, const MaskedSlabs& slabs) {
  if (const auto& eye = paint.rays.eye)
    PaintAlong<EyeRays>(paint, group, slabs,
                        eye->spans_less(group.x, group.y, group_side, tile_side, patch_span));
  else
    PaintAlong<ParallelRays>(paint, group, slabs, paint.rays.patches);
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(PaintGroup);

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

}  // namespace ringsplat
#endif
