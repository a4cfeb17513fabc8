#include "python/picture.hpp"

#include <utility>

#include "app/frame_output.hpp"
#include "base/log.hpp"
#include "images/image_io.hpp"

namespace ringsplat::python {

Picture picture_of(FrameResult&& result, const app::RenderOptions& options, const ValueRange& range,
                   const std::optional<app::Annotation>& annotation) {
  std::string why = app::why_empty(result, range);
  if (why.empty()) why = app::why_nearly_empty(result);
  if (!why.empty()) log_warning("{}", why);
  Picture picture;
  picture.image = std::move(result.image);
  picture.spec = std::move(result.spec);
  picture.asked = options.frame.how;
  picture.seconds = result.stats.seconds;
  picture.settings = app::picture_settings(picture.spec, options.volume.path, options.annotate);
  picture.background = options.background;
  if (annotation) picture.overlay = annotation->overlay(picture.spec, range);
  return picture;
}

std::vector<std::uint8_t> display(const Picture& picture) {
  return display_bytes(picture.image, picture.background, picture.overlay);
}

Bytes png(const Picture& picture) {
  return image_bytes(picture.image, ".png", picture.background, picture.settings, picture.overlay);
}

void save(const Picture& picture, const std::filesystem::path& file) {
  check_image_name(file, "the picture's file", !picture.background);
  write_image(picture.image, file, picture.background, picture.settings, picture.overlay);
}

}  // namespace ringsplat::python
