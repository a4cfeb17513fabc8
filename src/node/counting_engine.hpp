#pragma once
#include <memory>

#include "ringsplat/node/engine.hpp"

namespace ringsplat {

/// The engine of runs that only count: payloads have the bytes that `encoder`'s would have, but tell no more
/// than how many splats they stand for and of which regions. Each voxel stands for `voxel_weight` voxels of
/// its slice. `spec` and `geometry` are the encoder's and must outlive it.
std::unique_ptr<Encoder> make_counting_encoder(std::unique_ptr<Encoder> encoder, const FrameSpec& spec,
                                               const FrameGeometry& geometry, int renderers,
                                               double voxel_weight);

/// Takes such payloads and delivers black tiles of the regions that they were for; of a Renderer's regions,
/// those from the 64th on count as one.
std::unique_ptr<Painter> make_counting_painter(int renderer, int renderers);

}  // namespace ringsplat
