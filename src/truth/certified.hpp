#pragma once
#include <algorithm>
#include <glm/vector_relational.hpp>
#include <span>
#include <vector>

#include "truth/scene.hpp"

namespace ringsplat::truth {

/// Between which numbers a pixel's four channels surely are.
struct PixelBounds {
  Rgba low{0.0}, high{1.0};
  double width() const {  ///< of the widest channel
    const Rgba widths = high - low;
    return std::max({widths.r, widths.g, widths.b, widths.a});
  }
  Rgba middle() const { return 0.5 * (low + high); }
  Rgba nearest_to(const Rgba& colour) const { return glm::clamp(colour, low, high); }
  Rgba farthest_from(const Rgba& colour) const {
    return glm::mix(high, low, glm::greaterThan(glm::abs(colour - low), glm::abs(colour - high)));
  }
};

/// Bounds of the field's truth (field_truth), proved by arithmetic of intervals: docs/certified.md has the
/// proof. They are refined until no channel is wider than `width`, in a colour from 0 to 1, or until
/// `most_pieces` of a ray have been enclosed: bounds are then wider, but hold as well. In modes other than
/// compositing they are at once as narrow as numbers allow. All cores.
///
/// Throws InputError for Shown::values.
std::vector<PixelBounds> certified_bounds(const Scene& scene, std::span<const Pixel> pixels, double width,
                                          int most_pieces = 50'000);

}  // namespace ringsplat::truth
