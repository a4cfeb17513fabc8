#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/vec3.hpp>
#include <vector>

#include "classify/classifier.hpp"
#include "classify/normals.hpp"
#include "ringsplat/classify/material.hpp"

namespace ringsplat {

/// Shading by lookup (Neumann 1992, section 3): one entry for each quantised normal and its opposite, which
/// are lit alike. Rebuilt when the light or the view changes. Directions are in world space, towards the
/// light and towards the viewer.
class PhongTable {
 public:
  PhongTable(const PhongMaterial& material, const glm::dvec3& to_light, const glm::dvec3& to_viewer);

  /// A colour is multiplied by |scale|, then the highlight is added; it is clamped to 1. no_normal leaves it
  /// as it is (unlit, not black). Most normals have no highlight, and the table is larger than a thread's
  /// share of the cache. So a scale's sign bit says whether there is a highlight, and the others are not
  /// read.
  struct Entries {
    const float *scales, *highlights;
    /// Index of a place's highlight: the place itself, or 0 when it has none. Loads the sign by itself, which
    /// is faster than taking the scale out of a vector.
    std::size_t highlight_of(std::size_t place) const {
      std::int32_t sign;
      std::memcpy(&sign, scales + place, sizeof sign);
      return place & std::size_t(std::ptrdiff_t(sign >> 31));
    }
  };
  Entries entries() const { return {scales_.data(), highlights_.data()}; }
  /// A normal's place among the entries; numbers that are no code have that of no_normal.
  static std::uint16_t place_of(NormalCode normal) {
    return std::uint16_t(std::max(std::min(int(normal), opposite_codes - int(normal)), 0));
  }

 private:
  std::vector<float> scales_, highlights_;  ///< by place; place 0, of no_normal, has 1 and 0
};

/// A row of a slice.
struct VoxelRow {
  const std::byte* values;    ///< in native byte order, at any address
  const NormalCode* normals;  ///< may be null
  int columns;
};

/// Makes the samples of the visible voxels that classifier.find_row found in a row. Each is lit by its
/// normal, or unlit if `phong` or the normals are null. The same bits at every vector width.
void make_samples(const Classifier& classifier, const VoxelRow& row, const PhongTable* phong,
                  VisibleRow& out);

}  // namespace ringsplat
