#include <fmt/format.h>

#include "app/frame_output.hpp"
#include "base/child_program.hpp"
#include "base/output_file.hpp"
#include "images/image_io.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

std::filesystem::path find_ffmpeg(const std::string& output) {
  const auto ffmpeg = find_program("ffmpeg");
  if (!ffmpeg)
    throw InputError(fmt::format("-o {} needs ffmpeg, and no folder in PATH has it", output),
                     "install it (apt-get install ffmpeg), or write pictures: -o frame.png");
  return *ffmpeg;
}

}  // namespace

bool names_film(const std::filesystem::path& output) { return output.extension() == ".mp4"; }

void check_film(const RenderOptions& o) {
  if (o.orbit == 0 && o.path.empty() && !o.frames)
    throw InputError(fmt::format("-o {} is a film, and one view is none", o.output),
                     "turn around the volume with --orbit 120, or write a picture: -o picture.png");
  if (o.path == "-" || o.progressive)
    throw InputError(fmt::format("-o {}: a film has no part in {}", o.output,
                                 o.progressive ? "--progressive" : "--path -, which answers each view"),
                     "write pictures: -o frame.png");
  find_ffmpeg(o.output);
}

void Film::add(const Image& image, const std::optional<glm::dvec3>& background, const Overlay& overlay) {
  if (!movie_)
    movie_.emplace(find_ffmpeg("film.mp4"), serve::MoviePlan{.width = image.width, .height = image.height});
  movie_->add(count_++, image_bytes(image, ".png", background.value_or(glm::dvec3(0)), {}, overlay));
}

void Film::write(const std::filesystem::path& file) {
  if (!movie_) return;
  const std::string bytes = movie_->encode(serve::Movie::Clock::now() + std::chrono::hours(1));
  write_text(file, bytes);
  movie_.reset();
}

}  // namespace ringsplat::app
