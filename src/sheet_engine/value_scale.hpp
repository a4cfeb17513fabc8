#pragma once
#include "sheet_engine/sheet_frame.hpp"
#include "sheet_engine/table_axis.hpp"

namespace ringsplat {

/// What follows from a volume's values for a frame. GPs and Renderers find the same.
struct ValueScale {
  double low = 0, high = 0;  ///< the ends of the table's axis
  PlaneCode code;
};

/// For all of the volume's (the level's) values, which lie between `low` and `high`; these may be infinite,
/// and low > high when all are not-a-number.
ValueScale value_scale(const SheetFrame& frame, double low, double high);

}  // namespace ringsplat
