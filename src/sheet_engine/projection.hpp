#pragma once
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "raster/region_image.hpp"
#include "sheet_engine/paint_group.hpp"
#include "sheet_engine/place_map.hpp"
#include "sheet_engine/sheet_frame.hpp"

namespace ringsplat {

/// What a frame's rays project, in the numbers of planes.
Projection make_projection(const SheetFrame& frame, const ValueScale& scale);

/// What colours a single slice beside its values.
struct SliceLabels {
  const std::uint8_t* plane = nullptr;  ///< ScalarPlanes::labels(); null: there are none
  std::ptrdiff_t pitch = 0;
  const float* tints = nullptr;  ///< TintTable
};

/// The colours of projected values.
class ProjectionColours {
 public:
  /// Its opacities say of Mode::attenuated how much values dim, and not what is seen of them.
  void set_function(TransferFunction transfer_function, Mode mode);
  const glm::vec4& at(double value) const;

 private:
  static constexpr int last = 1 << 14;
  TransferFunction function_;
  double low_ = 0, steps_a_unit_ = 0;
  std::vector<glm::vec4> colours_;  ///< premultiplied
};

/// What colours the values that pixels have taken of a volume.
struct ProjectedVolume {
  const SheetFrame& frame;
  const ProjectionColours& colours;
  Projection projection;
  ValueScale scale;
  SliceLabels labels = {};
};

/// Turns what a region's pixels have taken of `volumes` (paint_group.hpp), each in its place, into their
/// colours, or the sum of these, which is at most 1. Rays that meet the box have a value, too, where nothing
/// was taken, but for frames that tell holes. `more`: the further values; null: there are none.
void colour_region(std::span<const ProjectedVolume> volumes, const SheetRays& rays, RegionImage& image,
                   RegionImage* more);

}  // namespace ringsplat
