#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "frame/engine_setup.hpp"
#include "protocol/engine.hpp"
#include "sheet_engine/sheet_frame.hpp"
#include "splat_engine/splat_frame.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

/// What a payload takes a Painter, besides its items: ItemCounts' numbers.
struct PaintWork {
  std::uint64_t blocks = 0, samples = 0;
};

/// Counts what a frame's payloads will take Painters, in the units of the engine that made them.
class Meter {
 public:
  virtual ~Meter() = default;
  /// By Renderer. `parts`: what an encoder that knows of no opaque pixels made of the slice of `step`.
  virtual std::vector<PaintWork> work_of(int step, const std::vector<EncodedPart>& parts) = 0;
};

/// Of splats, the pixels that are composited: as whole windows of kernels, so a few more than are. Each voxel
/// stands for `voxel_weight` of its slice.
std::unique_ptr<Meter> make_splat_meter(std::shared_ptr<const SplatFrame> frame, double voxel_weight = 1);
/// Of sheets, the blocks that Renderers look at and the pixels between slices that they paint.
std::unique_ptr<Meter> make_sheet_meter(std::shared_ptr<const SheetFrame> frame);

/// The payload of a slice that is only counted: what is left of the one that would have been sent.
struct MeasuredPayload {
  std::uint64_t bytes = 0;  ///< of the payload
  PaintWork work;
};
Bytes measured_payload(const MeasuredPayload& payload);

/// An encoder whose payloads are measured ones of `inner`'s.
std::unique_ptr<Encoder> make_measuring_encoder(std::unique_ptr<Encoder> inner, std::unique_ptr<Meter> meter);

/// A GP's encoder for a frame of sheets that is only counted, of a volume whose slices have `voxel_weight`
/// times as many voxels: as many blocks as those have, as large on the screen, are looked at and sent.
/// Payloads are measured ones (simulate/meter.hpp). `store` must outlive it. Throws RunError as
/// make_sheet_encoder().
std::unique_ptr<Encoder> make_weighed_encoder(std::shared_ptr<const SheetFrame> frame, int renderers,
                                              const SliceStore& store, double voxel_weight);

/// The engines of one rank, whose encoders make measured payloads (simulate/meter.hpp), which nobody can
/// draw. Each voxel stands for `voxel_weight` of its slice: sheets have as many blocks as those would
/// make; splats are as many as voxels, with kernels as large as those would have.
std::unique_ptr<Engine> make_measured_engines(const EngineSetup& setup, double voxel_weight);

class RegionDealer;

/// A frame of such splats; without a `dealer` regions are dealt in turn.
std::shared_ptr<const SplatFrame> make_weighed_frame(const FrameSpec& spec, const Grid& grid,
                                                     SliceDealing dealing, int renderers, double voxel_weight,
                                                     RegionDealer* dealer = nullptr);

}  // namespace ringsplat
