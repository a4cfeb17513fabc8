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
  /// Makes the folder; none is kept when its name is empty. Throws InputError when it cannot be made.
  explicit StudyPictures(const std::string& folder);
  bool kept() const { return !folder_.empty(); }

  /// SCENE/NAME-VIEW.png, of the view's number. Both return the file's name within the folder.
  std::string keep(const std::string& scene, const std::string& name, std::size_t view, const Image& image);
  /// SCENE/truth-KIND-VIEW.png; asks for the picture only once.
  std::string keep_truth(const std::string& scene, const std::string& kind, std::size_t view,
                         const std::function<Image()>& image);

 private:
  std::filesystem::path folder_;
  std::set<std::string> truths_;  ///< that are there
};

}  // namespace ringsplat::app
