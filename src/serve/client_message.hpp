#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "serve/scene_state.hpp"

/// What pages send (docs/viewer.md has the formats).
namespace ringsplat::serve {

struct ViewMessage {
  std::uint32_t seq = 0;
  bool moving = false;
  int width = 0, height = 0;
  double time = 0;  ///< the page's clock in milliseconds, sent back with the pictures
  SceneState scene;
};
struct AckMessage {
  std::uint32_t picture = 0;
};
struct DriveMessage {};
struct ProbeMessage {
  std::uint32_t id = 0;
  double x = 0, y = 0;  ///< pixels of the last view's picture
};
struct SnapshotMessage {
  std::uint32_t id = 0;
  int width = 0, height = 0;
  bool exr = false;
  SceneState scene;
};
using ClientMessage = std::variant<ViewMessage, AckMessage, DriveMessage, ProbeMessage, SnapshotMessage>;

/// What messages are read against.
struct MessageRules {
  SceneState initial;  ///< has what a message's scene leaves out
  glm::ivec3 dims{1};  ///< of the volume
  int largest_width = 4096, largest_height = 4096;
};

/// Throws InputError, for the page to show, when the text is no such message: no JSON, nested deeper than 8,
/// an unknown type, a number that is not finite or out of range.
ClientMessage parse_client_message(std::string_view text, const MessageRules& rules);

}  // namespace ringsplat::serve
