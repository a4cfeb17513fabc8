#pragma once
#include <memory>

#include "ringsplat/node/engine.hpp"

namespace ringsplat {

/// The engine of runs that only count: payloads have the bytes that `encoder`'s would have, but tell no more
/// than how many splats they stand for. Each voxel stands for `voxel_weight` voxels of its slice.
std::unique_ptr<Encoder> make_counting_encoder(std::unique_ptr<Encoder> encoder, double voxel_weight);

/// Takes such payloads and delivers black tiles of every region of this Renderer.
std::unique_ptr<Painter> make_counting_painter(int renderer, int renderers);

}  // namespace ringsplat
