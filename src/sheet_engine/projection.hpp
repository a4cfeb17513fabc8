#pragma once
#include <glm/vec4.hpp>
#include <vector>

#include "raster/region_image.hpp"
#include "sheet_engine/paint_group.hpp"
#include "sheet_engine/sheet_frame.hpp"
#include "sheet_engine/table_axis.hpp"

namespace ringsplat {

/// What a frame's rays project, in the numbers of planes.
Projection make_projection(const SheetFrame& frame, const PlaneCode& code);

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
  /// Turns what a region's pixels have taken, as painters left it, into their colours, or numbers. Rays that
  /// meet the box have a value, too, where nothing was taken.
  void colour(const SheetFrame& frame, const SheetRays& rays, const Projection& projection,
              const PlaneCode& code, const SliceLabels& labels, RegionImage& image) const;

 private:
  const glm::vec4& at(double value) const;

  static constexpr int last = 1 << 14;
  TransferFunction function_;
  double low_ = 0, steps_a_unit_ = 0;
  std::vector<glm::vec4> colours_;  ///< premultiplied
};

}  // namespace ringsplat
