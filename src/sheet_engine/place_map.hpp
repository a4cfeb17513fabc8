#pragma once
#include "sheet_engine/paint_group.hpp"
#include "sheet_engine/sheet_frame.hpp"
#include "sheet_engine/value_scale.hpp"
#include "sheet_engine/value_table.hpp"

namespace ringsplat {

/// How planes' numbers become places in a table of slabs, and which places are transparent.
PlaceMap place_map(const SheetFrame& frame, const ValueScale& scale, const TableAxis& axis);
/// The same in a table of single values, for frames that take the nearest voxels'.
PlaceMap place_map(const SheetFrame& frame, const ValueScale& scale, const ValueTable& values);

}  // namespace ringsplat
