#pragma once
#include <memory>

#include "sheet_engine/sheet_frame.hpp"
#include "support/views.hpp"

namespace ringsplat::test {

inline constexpr int renderers = 6;

/// A frame of sheets for so many Renderers, along the slices of z.
inline std::shared_ptr<const SheetFrame> seen_from_above(const Grid& grid, const TransferFunction& function) {
  FrameSpec spec = oblique_view(96, 96, 0);
  spec.shown.camera = {.azimuth = 0, .elevation = 90};
  spec.shown.transfer_function = function;
  spec.how = Sheets{};
  return make_sheet_frame(spec, grid, 1, renderers);
}

}  // namespace ringsplat::test
