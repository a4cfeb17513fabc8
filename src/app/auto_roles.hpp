#pragma once
#include <vector>

#include "app/places.hpp"
#include "options/options.hpp"
#include "program/launch.hpp"
#include "scene/load.hpp"

namespace ringsplat::app {

/// The layout for --gps auto and --renderers auto: the one in which frames of these views are foreseen to
/// take least, on the described machine or on this one. All ranks measure what a message costs; rank 0 prints
/// its choice on stderr. Layouts whose GPs cannot hold their slices are left out. `cameras` are needed on
/// rank 0 only; without any, the options' own view counts. All ranks call it before the volume is loaded; all
/// throw the same InputError.
Layout choose_roles(const RenderOptions& options, const std::vector<Camera>& cameras, const Grid& grid,
                    const LoadOptions& load, const std::vector<Place>& places, Launch& launch);

/// How many Renderers get regions: all, but two for each core when colocated ranks share cores. More would
/// not draw faster, and each one's token passes all slices.
int drawing_renderers(const Layout& layout, const std::vector<Place>& places, const Launch& launch);

}  // namespace ringsplat::app
