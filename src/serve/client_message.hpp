#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "serve/movie.hpp"
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
struct MovieFrameMessage {
  std::uint32_t id = 0;  ///< of the whole movie
  int index = 0;
  MoviePlan plan;
  SceneState scene;
};
/// The movie of that number is no longer wanted.
struct CancelMessage {
  std::uint32_t id = 0;
};
using ClientMessage = std::variant<ViewMessage, AckMessage, DriveMessage, ProbeMessage, SnapshotMessage,
                                   MovieFrameMessage, CancelMessage>;

/// What messages are read against.
struct MessageRules {
  SceneState initial;  ///< has what a message's scene leaves out
  glm::ivec3 dims{1};  ///< of the volume
  int frames = 1;      ///< volumes of the series
  int largest_width = 4096, largest_height = 4096;
};

/// Throws InputError, for the page to show, when the text is no such message: no JSON, nested deeper than 8,
/// an unknown type, a number that is not finite or out of range.
ClientMessage parse_client_message(std::string_view text, const MessageRules& rules);

/// What a page waits for an answer to.
struct Request {
  std::string type;  ///< "probe", "snapshot" or "movie_frame"; empty when it is none of them
  std::uint32_t id = 0;
};

/// Which request a message was, though it may be wrong; nothing when that cannot be told.
std::optional<Request> request_of(std::string_view text);

}  // namespace ringsplat::serve
