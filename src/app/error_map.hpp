#pragma once
#include <filesystem>
#include <string>

#include "app/render_job.hpp"
#include "serve/viewer.hpp"

namespace ringsplat::app {

/// Writes a picture of the errors that were measured of `picture`, with a bar that says what its colours
/// mean; transparent where none is known. `settings`: the picture's, as JSON; what the bar spans is added.
void write_error_map(const MeasuredError& error, const Image& picture, const std::filesystem::path& file,
                     const std::string& settings);

/// What all pixels of a picture of the job's volume of that number err at most, as ViewerOptions::errors has
/// it. Reads the whole volume.
serve::ProvedErrors proved_errors(const Job& job, const FrameResult& picture, int volume,
                                  const std::function<void()>& go_on);

}  // namespace ringsplat::app
