#pragma once
#include <memory>

#include "protocol/engine.hpp"
#include "sheet_engine/sheet_frame.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

/// A GP's encoder for a frame of sheets that is only counted, of a volume whose slices have `voxel_weight`
/// times as many voxels: as many blocks as those have, as large on the screen, are looked at and sent.
/// Payloads are measured ones (simulate/meter.hpp). `store` must outlive it. Throws RunError as
/// make_sheet_encoder().
std::unique_ptr<Encoder> make_weighed_encoder(std::shared_ptr<const SheetFrame> frame, int renderers,
                                              const SliceStore& store, double voxel_weight);

}  // namespace ringsplat
