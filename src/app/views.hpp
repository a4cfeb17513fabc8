#pragma once
#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "options/options.hpp"
#include "ringsplat/view/view.hpp"

namespace ringsplat::app {

/// `frames` views once around the volume: azimuths from start.azimuth on in steps of 360/frames degrees.
std::vector<Camera> orbit(const Camera& start, int frames);

/// A path. A line is a camera: "azimuth elevation [roll [zoom]]" with blanks, commas or semicolons, or a JSON
/// object with these keys, "fov", "distance" or "matrix" (12 numbers). Column names before the first view
/// give another order; lines that are empty or begin with # are skipped. Missing values are taken from
/// `defaults`. Throws InputError that names `where` and the line; also when there is no view, or more than
/// most_views.
std::vector<Camera> parse_path(std::istream& in, const std::string& where, const Camera& defaults);
constexpr std::size_t most_views = 1'000'000;

/// The run's views: one, an orbit or a path. Throws InputError for a path that cannot be read.
std::vector<Camera> views_of(const RenderOptions& options);

/// OUT.png -> OUT-0007.png.
std::filesystem::path numbered(const std::filesystem::path& file, std::size_t index);

}  // namespace ringsplat::app
