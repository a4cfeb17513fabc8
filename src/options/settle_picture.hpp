#pragma once
#include "options/option_list.hpp"
#include "options/options.hpp"

namespace ringsplat::app {

/// What all pictures have in common: completes the options once they are read. Throws InputError when they do
/// not fit together.
void settle_picture(const OptionList& list, RenderOptions& o);

}  // namespace ringsplat::app
