#include "study/study_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "images/image_io.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

namespace fs = std::filesystem;

/// Turns a list's name into a file name: only letters, digits, dots, dashes and underscores.
std::string as_file_name(std::string name) {
  const auto harmless = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '-' || c == '_';
  };
  std::replace_if(
      name.begin(), name.end(), [&](char c) { return !harmless(static_cast<unsigned char>(c)); }, '-');
  return name.front() == '.' ? "-" + name : name;
}

std::string file_of(const std::string& scene, const std::string& name, std::size_t view) {
  return fmt::format("{}/{}-{}.png", as_file_name(scene), as_file_name(name), view);
}

void make_folder(const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed || !fs::is_directory(folder))
    throw InputError(fmt::format("the folder {} cannot be made: {}", folder.string(), failed.message()),
                     "give --keep-images a folder that can be written");
}

void write(const Image& image, const fs::path& file) {
  make_folder(file.parent_path());
  write_image(image, file, glm::dvec3(0.0), {});
}

}  // namespace

StudyPictures::StudyPictures(const std::string& folder) : folder_(folder) {
  if (kept()) make_folder(folder_);
}

std::string StudyPictures::keep(const std::string& scene, const std::string& name, std::size_t view,
                                const Image& image) {
  const std::string file = file_of(scene, name, view);
  write(image, folder_ / file);
  return file;
}

std::string StudyPictures::keep_truth(const std::string& scene, const std::string& kind, std::size_t view,
                                      const std::function<Image()>& image) {
  const std::string file = file_of(scene, "truth-" + kind, view);
  if (truths_.insert(file).second) write(image(), folder_ / file);
  return file;
}

}  // namespace ringsplat::app
