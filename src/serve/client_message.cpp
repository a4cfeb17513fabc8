#include "serve/client_message.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "serve/json_fields.hpp"

namespace ringsplat::serve {
namespace {

using nlohmann::json;

constexpr int deepest = 8;

/// The parser and its values recurse, so texts are measured before it sees them.
int depth_of(std::string_view text) {
  int depth = 0, most = 0;
  bool in_text = false;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const char c = text[k];
    if (in_text && c == '\\')
      ++k;
    else if (c == '"')
      in_text = !in_text;
    else if (!in_text && (c == '[' || c == '{'))
      most = std::max(most, ++depth);
    else if (!in_text && (c == ']' || c == '}'))
      --depth;
  }
  return most;
}

SceneState scene_of(const json& j, const MessageRules& rules) {
  const auto state = j.find("state");
  return state == j.end() ? rules.initial : scene_from(*state, rules.initial, rules.dims, rules.frames);
}

int side(const json& j, const char* name, int largest) {
  return static_cast<int>(whole(j, name, 1, static_cast<std::uint32_t>(largest)));
}

ViewMessage view_from(const json& j, const MessageRules& rules) {
  ViewMessage view;
  view.seq = whole(j, "seq");
  view.moving = j.contains("moving") && j["moving"] == true;
  view.width = side(j, "width", rules.largest_width);
  view.height = side(j, "height", rules.largest_height);
  if (j.contains("time")) view.time = number(j, "time", -1e18, 1e18);
  view.scene = scene_of(j, rules);
  return view;
}

SnapshotMessage snapshot_from(const json& j, const MessageRules& rules) {
  SnapshotMessage snapshot;
  snapshot.id = whole(j, "id");
  snapshot.width = side(j, "width", rules.largest_width);
  snapshot.height = side(j, "height", rules.largest_height);
  const json& format = member(j, "format");
  if (format != "png" && format != "exr") throw InputError("format must be png or exr");
  snapshot.exr = format == "exr";
  snapshot.scene = scene_of(j, rules);
  return snapshot;
}

MovieFrameMessage movie_frame_from(const json& j, const MessageRules& rules) {
  constexpr std::uint32_t most_frames = 10000;
  MovieFrameMessage frame;
  frame.id = whole(j, "id");
  frame.plan.count = static_cast<int>(whole(j, "count", 1, most_frames));
  frame.index = static_cast<int>(whole(j, "index", 0, static_cast<std::uint32_t>(frame.plan.count - 1)));
  frame.plan.frames_a_second = number(j, "fps", 1, 120);
  frame.plan.width = side(j, "width", rules.largest_width);
  frame.plan.height = side(j, "height", rules.largest_height);
  frame.scene = scene_of(j, rules);
  return frame;
}

}  // namespace

ClientMessage parse_client_message(std::string_view text, const MessageRules& rules) {
  if (depth_of(text) > deepest)
    throw InputError(fmt::format("the message is nested deeper than {}", deepest));
  const json j = json::parse(text, nullptr, false);
  if (!j.is_object()) throw InputError("the message is no JSON object");
  const json& type = member(j, "type");
  if (type == "view") return view_from(j, rules);
  if (type == "ack") return AckMessage{whole(j, "picture")};
  if (type == "drive") return DriveMessage{};
  if (type == "probe")
    return ProbeMessage{whole(j, "id"), number(j, "x", 0, rules.largest_width),
                        number(j, "y", 0, rules.largest_height)};
  if (type == "snapshot") return snapshot_from(j, rules);
  if (type == "movie_frame") return movie_frame_from(j, rules);
  if (type == "cancel") return CancelMessage{whole(j, "id")};
  throw InputError("the message's type is not known");
}

std::optional<Request> request_of(std::string_view text) {
  if (depth_of(text) > deepest) return std::nullopt;
  const json j = json::parse(text, nullptr, false);
  if (!j.is_object()) return std::nullopt;
  const auto id = j.find("id");
  if (id == j.end() || !id->is_number_unsigned() || id->get<std::uint64_t>() > UINT32_MAX)
    return std::nullopt;
  Request request{"", id->get<std::uint32_t>()};
  for (const char* type : {"probe", "snapshot", "movie_frame"})
    if (const auto found = j.find("type"); found != j.end() && *found == type) request.type = type;
  return request;
}

}  // namespace ringsplat::serve
