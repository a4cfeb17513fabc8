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
void PaintBy(const SheetPaint& paint, const PixelGroup& group, std::span<const SheetSlab> slabs,
             const TileMask* masks, std::ptrdiff_t mask_stride) {
  Painter painter(paint, group);
  for (std::size_t k = 0; k < slabs.size(); ++k)
    if (const TileMask mask = masks[std::ptrdiff_t(k) * mask_stride]; mask != 0)
      painter.paint(slabs[k], mask);
  painter.store_pixels();
}

template <class Sampler, class Rays>
void PaintWith(const SheetPaint& paint, const PixelGroup& group, std::span<const SheetSlab> slabs,
               const TileMask* masks, std::ptrdiff_t mask_stride) {
  if (paint.projection.mode == Mode::composite)
    PaintBy<GroupPainter<Sampler, Rays>>(paint, group, slabs, masks, mask_stride);
  else
    PaintBy<ProjectionPainter<Sampler, Rays>>(paint, group, slabs, masks, mask_stride);
}

template <class Rays>
void PaintAlong(const SheetPaint& paint, const PixelGroup& group, std::span<const SheetSlab> slabs,
                const TileMask* masks, std::ptrdiff_t mask_stride, [[maybe_unused]] bool patches) {
  if (paint.floats) return PaintWith<FloatSampler, Rays>(paint, group, slabs, masks, mask_stride);
#if RINGSPLAT_LANES_PATCHES
  if (patches) return PaintWith<PatchSampler, Rays>(paint, group, slabs, masks, mask_stride);
#endif
  PaintWith<PairSampler, Rays>(paint, group, slabs, masks, mask_stride);
}

void PaintGroup(const SheetPaint& paint, const PixelGroup& group, std::span<const SheetSlab> slabs,
                const TileMask* masks, std::ptrdiff_t mask_stride) {
  if (const auto& eye = paint.rays.eye)
    PaintAlong<EyeRays>(paint, group, slabs, masks, mask_stride,
                        eye->spans_less(group.x, group.y, group_side, tile_side, patch_span));
  else
    PaintAlong<ParallelRays>(paint, group, slabs, masks, mask_stride, paint.rays.patches);
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(PaintGroup);

std::int32_t fixed_position(double voxels) {
  return static_cast<std::int32_t>(std::floor(voxels * one_voxel + 0.5));
}

float place_of_number(const PlaceMap& map, float number) {
  if (map.even) return std::fma(number, map.scale, map.offset);
  float place = 0;
  for (int k = 0; k < map.count; ++k) {
    const auto& ramp = map.ramps[std::size_t(k)];
    place = std::fma(std::min(std::max(number - ramp.from, 0.0F), ramp.width), ramp.rise, place);
  }
  return place;
}

void paint_group(const SheetPaint& paint, const PixelGroup& group, std::span<const SheetSlab> slabs,
                 const TileMask* masks, std::ptrdiff_t mask_stride) {
  HWY_DYNAMIC_DISPATCH(PaintGroup)(paint, group, slabs, masks, mask_stride);
}

}  // namespace ringsplat
#endif
