#pragma once
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

#include "app/annotation.hpp"
#include "options/options.hpp"
#include "ringsplat/base/bytes.hpp"
#include "session/director.hpp"
#include "study/measured_error.hpp"

namespace ringsplat::python {

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
                   const std::optional<app::Annotation>& annotation);

/// Display values, straight alpha: three bytes a pixel over a background, else four.
std::vector<std::uint8_t> display(const Picture& picture);
Bytes png(const Picture& picture);
/// Throws InputError for an ending that is no picture's, RunError when it cannot be written.
void save(const Picture& picture, const std::filesystem::path& file);

/// Renders one picture, or one of each view, in this process. Throws InputError and RunError.
std::vector<Picture> render_pictures(app::RenderOptions options, const Hooks& hooks);

/// Measures a picture of this volume. Throws InputError.
app::MeasuredError measure(const Picture& picture, const app::VolumeOptions& volume,
                           const app::ErrorOptions& error, const Hooks& hooks);

}  // namespace ringsplat::python
