#pragma once
#include <span>
#include <vector>

#include "truth/scene.hpp"

namespace ringsplat::truth {

/// What the scene's method draws, without the renderer's arithmetic: the truth of splats (splat_method.hpp)
/// or of sheets (sheet_method.hpp).
std::vector<Rgba> method_truth(const Scene& scene, std::span<const Pixel> pixels);

/// Outside of these pixels that truth is transparent.
ScreenBounds method_bounds(const Scene& scene);

}  // namespace ringsplat::truth
