#pragma once
#include <filesystem>
#include <functional>
#include <set>
#include <string>

#include "ringsplat/base/image.hpp"

namespace ringsplat::app {

/// Files of a measurement, relative to the folder; empty when they are not kept.
struct KeptPictures {
  std::string picture, truth;
};

/// The pictures of a study, as a display shows them: over black, 8-bit sRGB. One folder a scene.
class StudyPictures {
 public:
  /// Makes the folder, or throws InputError. With an empty name no picture is kept.
  explicit StudyPictures(const std::string& folder);
  bool kept() const { return !folder_.empty(); }

  /// Writes SCENE/NAME-VIEW.png, with the view's number. Both functions return the file's name within the
  /// folder.
  std::string keep(const std::string& scene, const std::string& name, std::size_t view, const Image& image);
  /// Writes SCENE/truth-KIND-VIEW.png; asks for the picture only once.
  std::string keep_truth(const std::string& scene, const std::string& kind, std::size_t view,
                         const std::function<Image()>& image);

 private:
  std::filesystem::path folder_;
  std::set<std::string> truths_;  ///< already written
};

}  // namespace ringsplat::app
