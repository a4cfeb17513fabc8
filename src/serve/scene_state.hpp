#pragma once
#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat::serve {

/// What a page can change of a picture.
struct SceneState {
  int frame = 0;  ///< which volume of a series, from 0
  Camera camera;
  TransferFunction transfer_function;
  Shading shading = Shading::phong;
  glm::dvec3 light{-0.4, 0.6, 0.7};
  std::optional<VoxelBox> clip;
  glm::dvec3 background{0.0};  ///< sRGB, 0..1
  bool operator==(const SceneState&) const = default;
};

nlohmann::json to_json(const TransferFunction& tf);
nlohmann::json to_json(const SceneState& scene);

/// Members that are missing are those of `initial`. Throws InputError naming the member that is wrong; `dims`
/// of the volume bound the clip box, `frames` is how many volumes there are.
SceneState scene_from(const nlohmann::json& j, const SceneState& initial, const glm::ivec3& dims,
                      int frames = 1);

/// `frame` with that scene. The background is not the frame's.
FrameSpec with_scene(FrameSpec frame, const SceneState& scene);

/// JSON for a client, whatever texts are in it.
std::string text_of(const nlohmann::json& j);

}  // namespace ringsplat::serve
