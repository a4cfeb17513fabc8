#pragma once
#include "sheet_engine/paint_group.hpp"
#include "sheet_engine/sheet_frame.hpp"
#include "sheet_engine/slab_table.hpp"

namespace ringsplat {

/// What follows from a volume's values for a frame. GPs and Renderers find the same.
struct ValueScale {
  double low = 0, high = 0;  ///< the ends of the table's axis
  PlaneCode code;
};

/// For all of the volume's (the level's) values, which lie between `low` and `high`; these may be infinite,
/// and low > high when all are not-a-number.
ValueScale value_scale(const SheetFrame& frame, double low, double high);

/// How planes' numbers become places in a table of slabs, and which places are transparent.
PlaceMap place_map(const SheetFrame& frame, const ValueScale& scale, const TableAxis& axis);
/// The same in a table of single values, for frames that take the nearest voxels'.
PlaceMap place_map(const SheetFrame& frame, const ValueScale& scale, const ValueTable& values);

}  // namespace ringsplat
