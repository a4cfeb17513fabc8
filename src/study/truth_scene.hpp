#pragma once
#include "ringsplat/frame/frame_spec.hpp"
#include "truth/scene.hpp"

namespace ringsplat::app {

/// Makes `scene` show the frame: its view, size, transfer function, light and method. Keeps grid and values,
/// so that a volume is read once for many frames.
void set_frame(truth::Scene& scene, const FrameSpec& spec);

}  // namespace ringsplat::app
