#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "ringsplat/view/view.hpp"

namespace ringsplat::app {

/// `frames` views once around the volume: azimuths from start.azimuth on in steps of 360/frames degrees.
std::vector<Camera> orbit(const Camera& start, int frames);

/// A camera a line: "azimuth elevation [roll [zoom]]" with blanks, commas or semicolons, or a JSON object
/// with these keys or "matrix" (12 numbers). A first line of column names gives another order; lines that are
/// empty or begin with # are skipped. What a line does not say is taken from `defaults`. Throws InputError
/// naming file and line.
std::vector<Camera> read_path(const std::filesystem::path& file, const Camera& defaults);
std::vector<Camera> parse_path(const std::string& text, const std::string& where, const Camera& defaults);

/// OUT.png -> OUT-0007.png.
std::filesystem::path numbered(const std::filesystem::path& file, std::size_t index);

}  // namespace ringsplat::app
