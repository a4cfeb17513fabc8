#pragma once
#include <optional>
#include <string>
#include <vector>

#include "options/options.hpp"

namespace ringsplat::app {

/// What `study` runs: every setting on every view of every scene.
struct StudyList {
  struct Scene {
    std::string name;
    std::string synth;     ///< a test volume, or empty
    VolumeOptions volume;  ///< a file, when `synth` is empty
    glm::ivec3 dims{64};
    ScalarType type = ScalarType::uint8;
    std::string transfer_function = "auto";
    ColourOptions colour;
    std::optional<ClipText> clip;
  };
  struct Setting {
    std::string name;
    MethodOptions method;
    Method how;  ///< what `method` means
    bool opacity_correction = true;
    Shading shading = Shading::none;
    int region_size = 0;  ///< as in Division
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
