#pragma once
#include "sheet_engine/paint_group.hpp"
#include "sheet_engine/sheet_frame.hpp"

namespace ringsplat {

/// Phong's reflection for gradients that are differences of plane numbers along u, v and the traversed axis.
/// `most`: the largest number; gradients are scaled by it so that their squares neither overflow nor vanish.
GradientLight gradient_light(const SheetFrame& frame, double most);

/// Sets what rays of a perspective frame need to know of lengths and of gradient_light()'s coordinates.
void set_lengths(const SheetFrame& frame, EyeGrid& eye);

}  // namespace ringsplat
