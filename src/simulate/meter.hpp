#pragma once
#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/common.hpp>
#include <glm/vec2.hpp>
#include <memory>
#include <span>
#include <vector>

#include "frame/engine_setup.hpp"
#include "frame/work_estimate.hpp"
#include "net/message.hpp"
#include "protocol/engine.hpp"
#include "sheet_engine/sheet_frame.hpp"
#include "simulate/machine.hpp"
#include "splat/footprint.hpp"
#include "splat_engine/splat_engine.hpp"
#include "volume/cell_ranges.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

/// What a payload takes a Painter, besides its items: ItemCounts' numbers.
struct PaintWork {
  std::uint64_t blocks = 0, samples = 0;
};

/// Counts what a slice's payloads will take Painters, in the units of the engine that made them, by Renderer.
/// `parts`: what an encoder that knows of no opaque pixels made of the slice of `step`.
using Meter = std::function<std::vector<PaintWork>(int step, const std::vector<EncodedPart>& parts)>;

/// Of splats, the pixels that are composited: as whole windows of kernels, so a few more than are. Each voxel
/// stands for `voxel_weight` of its slice.
Meter make_splat_meter(std::shared_ptr<const SplatFrame> frame, double voxel_weight = 1);
/// Of sheets, the blocks that Renderers look at and the pixels between slices that they paint.
Meter make_sheet_meter(std::shared_ptr<const SheetFrame> frame);

/// The payload of a slice that is only counted: what is left of the one that would have been sent.
struct MeasuredPayload {
  std::uint64_t bytes = 0;  ///< of the payload
  PaintWork work;
};
Bytes measured_payload(const MeasuredPayload& payload);

/// An encoder whose payloads are measured ones of `inner`'s, and whose items come with voxels.
std::unique_ptr<Encoder> make_measuring_encoder(std::unique_ptr<Encoder> inner, Meter meter);

/// A GP's encoder for a frame of sheets that is only counted, of a volume whose slices have `voxel_weight`
/// times as many voxels: as many blocks as those have, as large on the screen, are looked at and sent.
/// Payloads are measured ones. `store` must outlive it. Throws RunError as make_sheet_encoder().
std::unique_ptr<Encoder> make_weighed_encoder(std::shared_ptr<const SheetFrame> frame, int renderers,
                                              const SliceStore& store, double voxel_weight);

class RegionDealer;

/// A frame of splats that stand for `voxel_weight` of their slice each, with kernels as large as those would
/// have; without a `dealer` regions are dealt in turn.
std::shared_ptr<const SplatFrame> make_weighed_frame(const FrameSpec& spec, const Grid& grid,
                                                     SliceDealing dealing, int renderers, double voxel_weight,
                                                     RegionDealer* dealer = nullptr);

/// The engine of runs that only count. Payloads are as long as they would be, but hold only the number of
/// items and the tiles that these are for; tiles are black. Each voxel stands for `voxel_weight` voxels of
/// its slice. A Renderer's tiles from the 64th on count as one.
std::unique_ptr<Engine> make_counting_engine(EngineSetup setup, double voxel_weight);

/// How many slices such a payload is of.
int slices_counted(std::span<const std::byte> payload);

/// A Renderer's software for a payload and its accept on a described machine.
inline double payload_message_seconds(const Machine& m) {
  return sending_seconds(m, sizeof(Header)) + m.message.receive;
}

/// What work costs on a described machine, when each voxel stands for `voxel_weight` of its slice and slices
/// travel in bundles of `bundle`.
inline WorkCosts splat_costs(const Machine& m, double voxel_weight, int bundle = 1) {
  return {.voxel = voxel_weight * drawing_seconds(m, 1, 0, 0, 0),
          .pixel = drawing_seconds(m, 0, 0, 1, 0),
          .payload = drawing_seconds(m, 0, 0, 0) + payload_message_seconds(m) / bundle,
          .visible = voxel_weight * encoding_seconds(m, 1, 1, 0),
          .hollow = voxel_weight * encoding_seconds(m, 1, 0, 0)};
}
inline WorkCosts sheet_costs(const Machine& m, double voxel_weight, int bundle = 1) {
  constexpr double side = CellRanges::side;
  const double voxel = voxel_weight / (side * side);
  return {.voxel = voxel * placing_seconds(m, 0, 1, 0),
          .pixel = painting_seconds(m, 1),
          .payload = placing_seconds(m, 0, 0) + payload_message_seconds(m) / bundle,
          .visible = voxel * selecting_seconds(m, 1, 1, 0),
          .hollow = voxel * selecting_seconds(m, 1, 0, 0),
          .block = side / std::sqrt(voxel_weight)};
}

/// Half extents, in pixels, of the kernels of voxels that are `voxel_weight` times as many in a slice.
inline glm::dvec2 narrowed(const glm::dvec2& half, double voxel_weight) {
  return glm::min(half, glm::max(half / std::sqrt(voxel_weight), glm::dvec2(narrowest_half_width)));
}

}  // namespace ringsplat
