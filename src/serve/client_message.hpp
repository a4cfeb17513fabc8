#pragma once
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/volume/grid.hpp"
#include "serve/ruler.hpp"

/// What pages send (docs/viewer.md has the formats).
namespace ringsplat::serve {

/// How a channel is shown that is drawn with others.
struct ChannelState {
  bool visible = true;
  glm::dvec3 colour{1.0};  ///< sRGB, 0..1
  glm::dvec2 window{0.0};  ///< of values; a surface has its first
  bool operator==(const ChannelState&) const = default;
};

/// A picture that is wanted.
struct SceneState {
  int frame = 0;  ///< which volume of a series, from 0
  /// Another one, never the same, that is drawn from the same view.
  std::optional<int> compared = std::nullopt;
  int gain = 0;  ///< pages show the difference of the two, so many times; 0: both, side by side
  Shown shown;   ///< its camera, transfer function, shading, light, clip box and planes and size are
                 ///< the page's
  /// The volume is cut open along an axis' slices (0 to 2), or across the view (3), through a voxel.
  std::optional<glm::dvec4> cut = std::nullopt;
  glm::dvec3 background{0.0};  ///< sRGB, 0..1
  /// Each of the volume's; none where one is shown. They have functions of their own.
  std::vector<ChannelState> channels = {};

  bool shows(int volume) const { return frame == volume || compared == volume; }
  /// The volumes that must be held to draw it.
  std::vector<int> volumes() const { return compared ? std::vector{frame, *compared} : std::vector{frame}; }
  bool operator==(const SceneState&) const = default;
};

nlohmann::json to_json(const SceneState& scene);  ///< all that is the page's but the size

/// JSON for a client, whatever texts are in it.
std::string text_of(const nlohmann::json& j);

struct ViewMessage {
  std::uint32_t seq = 0;
  bool moving = false;
  double time = 0;  ///< the page's clock in milliseconds, sent back with the pictures
  SceneState scene;
};
struct AckMessage {
  std::uint32_t picture = 0;
};
struct DriveMessage {};
struct ProbeMessage {
  std::uint32_t id = 0;
  double x = 0, y = 0;       ///< the middle of a pixel of the last view's picture, from its corner
  bool of_compared = false;  ///< of the other volume's
  /// Whose voxel is asked for instead.
  std::optional<SceneState> scene = std::nullopt;
  glm::ivec3 voxel{0};
};
/// ParaView's colour map, to be used by the page.
struct MapMessage {
  std::uint32_t id = 0;
  TransferFunction transfer_function;
};
/// What all frames of a movie have in common.
struct MoviePlan {
  int count = 1;                ///< of frames
  double frames_a_second = 25;  ///< that it is shown with
  int width = 0, height = 0;
  bool operator==(const MoviePlan&) const = default;
};
struct MovieFrame {
  int index = 0;
  MoviePlan plan;
};
/// A snapshot, what errors a picture has, or a frame of a movie.
struct FileMessage {
  std::uint32_t id = 0;  ///< of a movie's frame the whole movie's
  SceneState scene;
  bool exr = false;
  std::optional<MovieFrame> movie;
  Ruler ruler = {};  ///< drawn over it, but for an EXR
  bool errors = false;
};
/// Of the volume only what the view shows is wanted, as fine as it can be held, or again all.
struct PartMessage {
  bool seen = true;
  SceneState scene;
};
/// The movie of that number is no longer wanted.
struct CancelMessage {
  std::uint32_t id = 0;
};

/// What becomes of the simulation that is shown.
struct SteerMessage {
  enum class Act { pause, step, resume, set } act = Act::pause;
  std::string parameter = {};  ///< that is set
  double value = 0;
};

using ClientMessage = std::variant<ViewMessage, AckMessage, DriveMessage, ProbeMessage, MapMessage,
                                   FileMessage, PartMessage, CancelMessage, SteerMessage>;

/// What messages are read against.
struct MessageRules {
  SceneState initial;  ///< has what a message's scene leaves out
  Grid grid;           ///< of the volume
  bool patient = false;
  int frames = 1;  ///< volumes of the series
  int largest_side = 4096;
};

/// What shows one slice of the volume.
inline VoxelBox slice_box(const Grid& grid, int axis, int index) {
  VoxelBox box = whole_box(grid);
  box.first[axis] = index;
  box.end[axis] = index + 1;
  return box;
}

/// Members that are missing are those of the initial scene. Throws InputError naming the member that is
/// wrong.
SceneState scene_from(const nlohmann::json& j, const MessageRules& rules);

/// Throws InputError, for the page to show, when the text is no such message: no JSON, nested deeper than 8,
/// an unknown type, a number that is not finite or out of range.
ClientMessage parse_client_message(std::string_view text, const MessageRules& rules);

/// The number of a message that may be wrong otherwise; nothing when it has none.
std::optional<std::uint32_t> id_of(std::string_view text);

}  // namespace ringsplat::serve
