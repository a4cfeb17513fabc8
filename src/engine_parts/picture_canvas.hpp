#pragma once
#include <cstdint>
#include <memory>

#include "frame/engine_setup.hpp"
#include "frame/frame_geometry.hpp"
#include "protocol/engine.hpp"

namespace ringsplat {

/// Puts the tiles of frame `number` into the picture, by a warp where the image plane is not the screen.
/// Tiles are rows of premultiplied RGBA floats.
std::unique_ptr<Canvas> make_picture_canvas(std::int64_t number, const Shown& shown,
                                            std::shared_ptr<const FrameGeometry> geometry, TakePicture take);

}  // namespace ringsplat
