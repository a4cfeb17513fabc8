#pragma once
#include <string>
#include <vector>

#include "options/options.hpp"

/// The command line's options of a picture, from the same tables.
namespace ringsplat::python {

/// Where a picture's volume comes from: options of files, errors and threads make no sense for a session's.
enum class From { volume, session };

/// Options of one picture, or of `views` that share them, from words of a command line such as
/// "--azimuth=30". What opens the volume is left to the caller. Throws InputError as the command line does.
app::RenderOptions parse_picture(const std::vector<std::string>& words,
                                 const std::vector<app::ViewAngles>& views, From from);

/// --gps, --renderers, --roles, --topology, --mesh and --routing for a job of so many ranks; `over_mpi`: else
/// all are in this process. Without words every rank hosts a GP and a Renderer. Throws InputError.
Layout parse_layout(const std::vector<std::string>& words, bool over_mpi, int ranks);

/// All options of parse_picture as a JSON array of {"name", "form", "default", "help", "group", "values",
/// "session"}: `values` is how many words follow the name, `session` whether a session has it.
std::string picture_options_json();

}  // namespace ringsplat::python
