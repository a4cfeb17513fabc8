#pragma once
#include "serve/viewer.hpp"

namespace ringsplat::serve {

/// What all levels of all views of the frame need.
LoadOptions needed_for_levels(const FrameSpec& frame, const Grid& grid);

/// The side of the largest picture whose floats leave room for the rest of this machine's memory.
int largest_side();

/// The modes that a page offers for such values, each with its first function; `usual` is that of light.
std::vector<std::pair<Mode, TransferFunction>> modes_for(const TransferFunction& usual,
                                                         const ValueStatistics& values, const Grid& grid);

}  // namespace ringsplat::serve
