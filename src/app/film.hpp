#pragma once
#include <filesystem>
#include <optional>

#include "images/drawing.hpp"
#include "options/options.hpp"
#include "ringsplat/base/image.hpp"
#include "serve/movie.hpp"

/// -o FILM.mp4: a run's pictures as one file, made by ffmpeg.
namespace ringsplat::app {

bool names_film(const std::filesystem::path& output);
/// Throws InputError for a run that makes no film, and where there is no ffmpeg.
void check_film(const RenderOptions& options);

class Film {
 public:
  /// Appends a picture over a background in linear light; none: black.
  void add(const Image& image, const std::optional<glm::dvec3>& background, const Overlay& overlay);
  /// Takes as long as ffmpeg does. Throws RunError when it fails or the file cannot be written; a file that
  /// had the name is then still there.
  void write(const std::filesystem::path& file);

 private:
  std::optional<serve::Movie> movie_;
  int count_ = 0;
};

}  // namespace ringsplat::app
