#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "serve/viewer.hpp"

/// The JSON texts that a viewer sends (docs/viewer.md).
namespace ringsplat::serve {

/// What lies under a pixel.
struct Probed {
  bool hit = false;
  glm::dvec3 voxel{0.0};  ///< lattice coordinates
  glm::dvec3 world{0.0};
  double value = 0;
};

std::string hello_text(const ViewerOptions& options, const std::vector<Level>& levels, bool drives,
                       int viewers);
std::string driver_text(bool drives, int viewers);
/// What becomes of a frame of a series: "loading", "shown" from now on, or "failed".
std::string frame_text(int frame, std::string_view status);
std::string state_text(const SceneState& scene);
std::string map_text(const MapMessage& map);
std::string probe_text(std::uint32_t id, const Probed& probed);
/// A movie's frame is there; another may come.
std::string movie_frame_text(std::uint32_t id, int index);
/// `what`: an error's text, "WHAT IS WRONG; hint: WHAT TO DO". `request`: that it answers.
std::string error_text(std::string_view what, const std::optional<Request>& request);
/// `what`: as of an error.
std::string warning_text(std::string_view what);
std::string end_text(const std::string& message);
std::string ended_by_signal_text(int number);

}  // namespace ringsplat::serve
