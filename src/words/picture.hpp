#pragma once
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/annotation.hpp"
#include "options/options.hpp"
#include "session/render_frames.hpp"
#include "study/error_budget.hpp"

namespace ringsplat::words {

// The command line's options of a picture, from the same tables.

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

// Pictures.

/// What long work calls now and then on the thread that called it; either may throw to end the work. Either
/// may be empty.
struct Hooks {
  std::function<void()> poll;
  std::function<void(const std::string& what, double done, double total)> told;
};

/// A picture, and what people want to know of it.
struct Picture {
  Image image;  ///< without background and annotations
  FrameSpec spec;
  Method asked;          ///< what an error budget may have made cheaper
  double seconds = 0;    ///< from the frame's announcement to its picture
  std::string settings;  ///< JSON
  std::optional<glm::dvec3> background;
  Overlay overlay;
  std::optional<app::MeasuredError> error;
};

/// A picture of a frame that was rendered with `options`; `range`: the volume's. Warns, in the log, of one
/// that shows nothing.
Picture picture_of(FrameResult&& result, const app::RenderOptions& options, const ValueRange& range,
                   const std::optional<app::Annotation>& annotation,
                   const std::vector<app::DrawnChannel>& channels = {});

/// Renders one picture, or one of each view, in this process. Throws InputError and RunError.
std::vector<Picture> render_pictures(app::RenderOptions options, const Hooks& hooks);

/// Measures a picture of this volume. Throws InputError.
app::MeasuredError measure(const Picture& picture, const app::VolumeOptions& volume,
                           const app::ErrorOptions& error, const Hooks& hooks);

}  // namespace ringsplat::words
