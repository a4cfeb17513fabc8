#pragma once
#include <vector>

#include "app/launch.hpp"
#include "app/options.hpp"
#include "scene/load.hpp"

namespace ringsplat::app {

/// The layout for --gps auto and --renderers auto: rank 0 measures what frames of these views cost, all ranks
/// what a message costs, and rank 0 says on stderr what it chose and why. Layouts whose GPs cannot hold their
/// slices are left out. `cameras` are needed on rank 0 only; without any, the options'
/// own view is measured. All ranks call it before the volume is loaded;
/// all throw the same InputError.
Layout choose_roles(const RenderOptions& options, const std::vector<Camera>& cameras, const Grid& grid,
                    const LoadOptions& load, Launch& launch);

/// How many Renderers get regions: all; of colocated ranks that share cores, two for each core. More would
/// not draw faster, and a token goes through all slices for each. All ranks call it.
int drawing_renderers(const Layout& layout, Launch& launch);

}  // namespace ringsplat::app
