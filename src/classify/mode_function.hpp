#pragma once
#include <optional>

#include "classify/auto_preset.hpp"
#include "ringsplat/classify/mode.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat {

/// The colours of a mode's values: grey from black at the low end of `window` to white at its high end, which
/// is chosen where it is not given; opaque throughout. Of a surface one colour for all values. The grid
/// tells what integrals may be.
AutoChoice choose_for_mode(Mode mode, const ValueStatistics& values, const Grid& grid,
                           const std::optional<DataRange>& window);

/// The value that parts the volume's values best into two classes (Otsu 1979).
double parting_value(const ValueStatistics& values);

}  // namespace ringsplat
