#pragma once
#include <string>
#include <vector>

#include "options/options.hpp"

namespace ringsplat::app {

/// What `study` runs: every setting on every view of every scene.
struct StudyList {
  struct Scene {
    std::string name;
    std::string synth;  ///< a test volume, or empty
    glm::ivec3 dims{64};
    ScalarType type = ScalarType::uint8;
    RenderOptions options;  ///< the volume's file, when `synth` is empty; function, colours and clip box
  };
  struct Setting {
    std::string name;
    RenderOptions options;  ///< the method and what else a frame says of itself
    Setting() { options.frame.shown.shading = Shading::none; }
  };
  std::vector<Scene> scenes;
  std::vector<Setting> settings;
  std::vector<Camera> views;
  std::vector<TruthKind> truths{TruthKind::method, TruthKind::field};
  int width = 256, height = 256;
  int repetitions = 5;
  std::size_t error_pixels = 4096;
  std::uint64_t seed = 1;
};

/// The default list, TOML with comments.
extern const char* const default_study_list;

/// Throws InputError that names `where`, section and key: unknown key, bad value, or nothing to run.
StudyList parse_study_list(const std::string& toml, const std::string& where);

}  // namespace ringsplat::app
