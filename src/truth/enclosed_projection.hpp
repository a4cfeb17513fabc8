#pragma once
#include <span>
#include <vector>

#include "truth/certified.hpp"
#include "truth/series.hpp"

namespace ringsplat::truth {

/// The largest of a polynomial's values over [0, 1].
Interval greatest_of(const Polynomial& p);

/// certified_bounds() in all modes but compositing. No clip box.
std::vector<PixelBounds> projected_bounds(const Scene& scene, std::span<const Pixel> pixels);

}  // namespace ringsplat::truth
