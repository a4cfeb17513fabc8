#pragma once
#include <filesystem>
#include <string>

#include "ringsplat/base/image.hpp"
#include "study/error_budget.hpp"

namespace ringsplat::app {

/// Writes a picture of the errors that were measured of `picture`, with a bar that says what its colours
/// mean; transparent where none is known. `settings`: the picture's, as JSON; what the bar spans is added.
void write_error_map(const MeasuredError& error, const Image& picture, const std::filesystem::path& file,
                     const std::string& settings);

}  // namespace ringsplat::app
