#include "serve/client_message.hpp"

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "base/srgb.hpp"
#include "base/text.hpp"
#include "frame/frame_geometry.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "frame/slices.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Camera, azimuth, elevation, roll, zoom, pan, fov, distance)

namespace serve {
namespace {

using nlohmann::json;

constexpr int deepest = 8;
constexpr double any = 1e300;                                  // leaves room for sums and differences
constexpr std::size_t most_points = 1100, longest_name = 200;  // points: four for each of 256 labels

// Members of untrusted JSON; all throw InputError that names the member.

double number_from(const json& j, const std::string& name, double low, double high) {
  const double value = j.is_number() ? j.get<double>() : NAN;
  if (!(value >= low && value <= high))
    throw InputError(fmt::format("{} must be a number from {:g} to {:g}", name, low, high));
  return value;
}

const json& member(const json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end()) throw InputError(fmt::format("the message has no {}", name));
  return *found;
}

double number(const json& object, const char* name, double low, double high) {
  return number_from(member(object, name), name, low, high);
}

/// A whole number up to 2^32 − 1.
std::uint32_t whole(const json& object, const char* name, std::uint32_t low = 0,
                    std::uint32_t high = UINT32_MAX) {
  const double value = number(object, name, low, high);
  if (value != std::floor(value)) throw InputError(fmt::format("{} must be a whole number", name));
  return static_cast<std::uint32_t>(value);
}

/// A list of `least` to `most` entries.
const json& list_from(const json& j, const std::string& name, std::size_t least, std::size_t most) {
  if (!j.is_array() || j.size() < least || j.size() > most)
    throw InputError(least == most ? fmt::format("{} must be a list of {}", name, least)
                                   : fmt::format("{} must be a list of {} to {}", name, least, most));
  return j;
}

glm::dvec3 vector_from(const json& j, const std::string& name, double low, double high) {
  list_from(j, name, 3, 3);
  glm::dvec3 v;
  for (int k = 0; k < 3; ++k) v[k] = number_from(j[std::size_t(k)], name, low, high);
  return v;
}

// The scene.

Camera camera_from(const json& j, Camera c) {
  if (!j.is_object()) throw InputError("camera must be an object");
  c.azimuth = number(j, "azimuth", -1e6, 1e6);
  c.elevation = number(j, "elevation", -1e6, 1e6);
  c.roll = number(j, "roll", -1e6, 1e6);
  c.zoom = number(j, "zoom", 1e-6, 1e6);
  c.fov = number(j, "fov", 0, 179);
  c.distance = number(j, "distance", 0, 1e5);
  const json& pan = list_from(member(j, "pan"), "pan", 2, 2);
  for (std::size_t k = 0; k < 2; ++k) c.pan[k] = number_from(pan[k], "pan", -1e6, 1e6);
  return c;
}

TransferFunction transfer_function_from(const json& j, TransferFunction tf) {
  if (!j.is_object()) throw InputError("transfer_function must be an object");
  const json& name = member(j, "name");
  if (!name.is_string() || name.get_ref<const std::string&>().size() > longest_name)
    throw InputError(fmt::format("name must be a text of at most {} bytes", longest_name));
  tf.name = name.get<std::string>();
  tf.colours.clear();
  tf.opacities.clear();
  for (const json& point : list_from(member(j, "colours"), "colours", 2, most_points)) {
    list_from(point, "a colour", 4, 4);
    tf.colours.push_back({number_from(point[0], "a colour's value", -any, any),
                          vector_from({point[1], point[2], point[3]}, "a colour", 0, 1)});
  }
  for (const json& point : list_from(member(j, "opacities"), "opacities", 2, most_points)) {
    list_from(point, "an opacity", 2, 2);
    tf.opacities.push_back(
        {number_from(point[0], "an opacity's value", -any, any), number_from(point[1], "an opacity", 0, 1)});
  }
  check(tf, "transfer_function");
  return tf;
}

Mode mode_from(const json& j) {
  for (const Mode mode : every_mode)
    if (j == name(mode)) return mode;
  std::string words = detail::joined(every_mode, ", ", [](Mode mode) { return name(mode); });
  throw InputError("mode must be " + words.replace(words.rfind(", "), 2, " or "));
}

VoxelBox box_from(const json& j, const glm::ivec3& dims) {
  list_from(j, "clip", 3, 3);
  VoxelBox box;
  for (int k = 0; k < 3; ++k) {
    const json& side = list_from(j[std::size_t(k)], "a side of clip", 2, 2);
    box.first[k] = static_cast<int>(number_from(side[0], "a side of clip", 0, dims[k] - 1));
    box.end[k] = static_cast<int>(number_from(side[1], "a side of clip", box.first[k] + 1, dims[k]));
  }
  return box;
}

ClipPlane plane_from(const json& j) {
  list_from(j, "a clip plane", 4, 4);
  return {vector_from({j[0], j[1], j[2]}, "a clip plane's direction", -1e6, 1e6),
          number_from(j[3], "a clip plane's distance", -any, any)};
}

ChannelState channel_from(const json& j) {
  const json& window = list_from(member(j, "window"), "a channel's window", 2, 2);
  const double low = number_from(window[0], "a channel's window", -any, any);
  return {member(j, "visible") == true,
          vector_from(member(j, "colour"), "a channel's colour", 0, 1),
          {low, number_from(window[1], "the end of a channel's window", low, any)}};
}

// The messages.

/// Refuses deep nesting while it is read: values recurse when they are written or destroyed.
json parsed(std::string_view text) {
  const auto shallow = [](int depth, json::parse_event_t event, json&) {
    using Event = json::parse_event_t;
    if ((event == Event::object_start || event == Event::array_start) && depth >= deepest)
      throw InputError(fmt::format("the message is nested deeper than {}", deepest));
    return true;
  };
  json j = json::parse(text, shallow, false);
  if (!j.is_object()) throw InputError("the message is no JSON object");
  return j;
}

/// The plane across a view through a place of the lattice.
ClipPlane plane_across_view(const Camera& camera, const Grid& grid, const glm::dvec3& place) {
  return plane_across(grid, make_view(camera, lattice_frame(grid), 1, 1).to_viewer, place);
}

/// `cut`: an axis, or 3 for across the view, and a voxel.
ClipPlane plane_of(const glm::dvec4& cut, const Camera& camera, const Grid& grid) {
  const glm::dvec3 place(cut.y, cut.z, cut.w);
  return cut.x < 3 ? plane_along_slices(grid, Axis(int(cut.x)), place)
                   : plane_across_view(camera, grid, place);
}

/// Has the scene show one slice of the whole volume and nothing else, opaque, from straight before it. `j`:
/// axis and index, or a voxel through which the slice goes across the view.
void show_slice(Shown& shown, const json& j, const MessageRules& rules) {
  const Grid& grid = rules.grid;
  Camera& camera = shown.camera;
  list_from(j, "slice", 2, 3);
  shown.clip.reset();
  shown.clip_planes.clear();
  shown.cut.reset();
  if (j.size() == 3) {
    const glm::dvec3 place = vector_from(j, "the slice's voxel", -0.5, 1e9);
    camera = {.azimuth = camera.azimuth, .elevation = camera.elevation, .roll = camera.roll};
    shown.clip_planes = planes_of_slice(plane_across_view(camera, grid, place), grid);
  } else {
    const auto axis = static_cast<int>(number_from(j[0], "the slice's axis", 0, 2));
    const auto index = static_cast<int>(number_from(j[1], "the slice", 0, grid.dims[axis] - 1));
    shown.clip = slice_box(grid, axis, index);
    camera = facing_slices(lattice_frame(grid), Axis(axis), rules.patient);
  }
  show_values(shown);
}

SceneState scene_of(const json& message, const MessageRules& rules) {
  SceneState scene = scene_from(message.value("state", json::object()), rules);
  const auto most = static_cast<std::uint32_t>(rules.largest_side);
  scene.shown.width = static_cast<int>(whole(message, "width", 1, most));
  scene.shown.height = static_cast<int>(whole(message, "height", 1, most));
  if (message.contains("slice")) show_slice(scene.shown, message["slice"], rules);
  return scene;
}

ProbeMessage probe_from(const json& j, const MessageRules& rules) {
  if (!j.contains("voxel"))
    return {whole(j, "id"), std::floor(number(j, "x", 0, rules.largest_side)) + 0.5,
            std::floor(number(j, "y", 0, rules.largest_side)) + 0.5, j.value("compared", json()) == true};
  ProbeMessage probe{whole(j, "id")};
  const json& voxel = list_from(j["voxel"], "voxel", 3, 3);
  for (int k = 0; k < 3; ++k)
    probe.voxel[k] = static_cast<int>(number_from(voxel[std::size_t(k)], "voxel", 0, rules.grid.dims[k] - 1));
  probe.scene = scene_from(j.value("state", json::object()), rules);
  return probe;
}

ViewMessage view_from(const json& j, const MessageRules& rules) {
  return {whole(j, "seq"), j.contains("moving") && j["moving"] == true,
          j.contains("time") ? number(j, "time", -1e18, 1e18) : 0, scene_of(j, rules)};
}

/// In few digits, as the page sends it back with each view.
MapMessage map_from(const json& j) {
  MapMessage message{whole(j, "id"), parse_transfer_function(member(j, "map").dump(), "the file")};
  TransferFunction& map = message.transfer_function;
  for (auto& point : map.colours)
    for (int k = 0; k < 3; ++k) point.srgb[k] = std::round(point.srgb[k] * 1e6) / 1e6;
  map = transfer_function_from(to_json(map), map);
  return message;
}

Ruler ruler_from(const json& j) {
  Ruler ruler;
  if (j.contains("ruler"))
    for (const json& place : list_from(j["ruler"], "ruler", 0, 3))
      ruler.push_back(vector_from(place, "a place of the ruler", -1e6, 1e6));
  return ruler;
}

FileMessage snapshot_from(const json& j, const MessageRules& rules) {
  const json& format = member(j, "format");
  if (format != "png" && format != "exr") throw InputError("format must be png or exr");
  return {whole(j, "id"), scene_of(j, rules), format == "exr", {}, ruler_from(j)};
}

FileMessage movie_frame_from(const json& j, const MessageRules& rules) {
  constexpr std::uint32_t most_frames = 10000;
  FileMessage file{whole(j, "id"), scene_of(j, rules), false, {}, ruler_from(j)};
  const std::uint32_t count = whole(j, "count", 1, most_frames);
  file.movie = {
      static_cast<int>(whole(j, "index", 0, count - 1)),
      {static_cast<int>(count), number(j, "fps", 1, 120), file.scene.shown.width, file.scene.shown.height}};
  return file;
}

PartMessage part_from(const json& j, const MessageRules& rules) {
  const json& seen = member(j, "seen");
  if (!seen.is_boolean()) throw InputError("seen must be true or false");
  return {seen.get<bool>(), scene_of(j, rules)};
}

SteerMessage steer_from(const json& j) {
  using Act = SteerMessage::Act;
  const json& act = member(j, "act");
  if (act == "pause") return {Act::pause};
  if (act == "step") return {Act::step};
  if (act == "resume") return {Act::resume};
  if (act != "set") throw InputError("act must be pause, step, resume or set");
  const json& name = member(j, "parameter");
  if (!name.is_string()) throw InputError("parameter must be a text");
  return {Act::set, name.get<std::string>(), number(j, "value", -any, any)};
}

}  // namespace

json to_json(const SceneState& s) {
  json clip, cut, planes = json::array(), channels = json::array(), tints = json::array();
  for (const auto& [visible, colour, window] : s.channels)
    channels.push_back(
        {{"visible", visible}, {"colour", {colour.x, colour.y, colour.z}}, {"window", {window.x, window.y}}});
  if (s.shown.clip)
    for (int k = 0; k < 3; ++k) clip.push_back({s.shown.clip->first[k], s.shown.clip->end[k]});
  if (s.cut) cut = {s.cut->x, s.cut->y, s.cut->z, s.cut->w};
  for (const auto& [normal, distance] : s.shown.clip_planes)
    planes.push_back({normal.x, normal.y, normal.z, distance});
  for (const auto& [label, light, share] : s.shown.tints) {
    const glm::dvec3 colour = linear_to_srgb(glm::dvec3(light));
    tints.push_back({label, colour.r, colour.g, colour.b, share});
  }
  return {{"frame", s.frame},
          {"compare", s.compared ? json(*s.compared) : json()},
          {"difference", s.gain},
          {"camera", s.shown.camera},
          {"transfer_function", to_json(s.shown.transfer_function)},
          {"mode", name(s.shown.mode)},
          {"isovalue", s.shown.isovalue},
          {"materials", s.shown.mixed},
          {"shading", s.shown.shading == Shading::phong ? "phong" : "none"},
          {"light", {s.shown.light.x, s.shown.light.y, s.shown.light.z}},
          {"clip", clip},
          {"clip_planes", planes},
          {"cut", cut},
          {"channels", channels},
          {"tints", tints},
          {"background", {s.background.x, s.background.y, s.background.z}}};
}

std::string text_of(const json& j) { return j.dump(-1, ' ', false, json::error_handler_t::replace); }

SceneState scene_from(const json& j, const MessageRules& rules) {
  if (!j.is_object()) throw InputError("state must be an object");
  json state = to_json(rules.initial);
  state.merge_patch(j);
  SceneState scene = rules.initial;
  Shown& shown = scene.shown;
  const auto last_frame = static_cast<std::uint32_t>(rules.frames - 1);
  scene.frame = static_cast<int>(whole(state, "frame", 0, last_frame));
  scene.compared.reset();
  if (rules.frames > 1 && !state.value("compare", json()).is_null())
    scene.compared = static_cast<int>(whole(state, "compare", 0, last_frame));
  if (scene.compared == scene.frame) scene.compared.reset();
  scene.gain = static_cast<int>(whole(state, "difference", 0, 16));
  if (scene.gain != 0 && scene.gain != 1 && scene.gain != 4 && scene.gain != 16)
    throw InputError("difference must be 0, 1, 4 or 16");
  shown.camera = camera_from(member(state, "camera"), shown.camera);
  shown.transfer_function =
      transfer_function_from(member(state, "transfer_function"), shown.transfer_function);
  shown.mode = mode_from(member(state, "mode"));
  shown.isovalue = number(state, "isovalue", -any, any);
  shown.mixed = member(state, "materials") == true && rules.initial.shown.tints.empty();
  const json& shading = member(state, "shading");
  if (shading != "phong" && shading != "none") throw InputError("shading must be phong or none");
  shown.shading = shading == "phong" ? Shading::phong : Shading::none;
  shown.light = vector_from(member(state, "light"), "light", -1e6, 1e6);
  shown.clip.reset();
  if (const json clip = state.value("clip", json()); !clip.is_null())
    shown.clip = box_from(clip, rules.grid.dims);
  shown.clip_planes.clear();
  for (const json& plane : list_from(member(state, "clip_planes"), "clip_planes", 0, most_clip_planes_of_cut))
    shown.clip_planes.push_back(plane_from(plane));
  shown.cut.reset();
  scene.cut.reset();
  if (const json cut = state.value("cut", json()); !cut.is_null()) {
    list_from(cut, "cut", 4, 4);
    scene.cut = {number_from(cut[0], "the cut's axis", 0, 3), 0, 0, 0};
    if (scene.cut->x != std::floor(scene.cut->x)) throw InputError("the cut's axis must be a whole number");
    for (int k = 0; k < 3; ++k)
      (*scene.cut)[k + 1] =
          number_from(cut[std::size_t(k) + 1], "the cut's voxel", -0.5, rules.grid.dims[k] - 0.5);
    if (shown.mode != Mode::sum) shown.cut = plane_of(*scene.cut, shown.camera, rules.grid);
  }
  scene.background = vector_from(member(state, "background"), "background", 0, 1);
  const std::size_t channels = scene.channels.size();
  const json& looks = list_from(member(state, "channels"), "channels", channels, channels);
  for (std::size_t k = 0; k < channels; ++k) scene.channels[k] = channel_from(looks[k]);
  const json& tints = list_from(member(state, "tints"), "tints", shown.tints.size(), shown.tints.size());
  for (std::size_t k = 0; k < shown.tints.size(); ++k) {
    const json& tint = list_from(tints[k], "a tint", 5, 5);
    shown.tints[k].colour = srgb_to_linear(vector_from({tint[1], tint[2], tint[3]}, "a tint's colour", 0, 1));
    shown.tints[k].share = float(number_from(tint[4], "a tint's share", 0, 1));
  }
  return scene;
}

ClientMessage parse_client_message(std::string_view text, const MessageRules& rules) {
  const json j = parsed(text);
  const json& type = member(j, "type");
  if (type == "view") return view_from(j, rules);
  if (type == "ack") return AckMessage{whole(j, "picture")};
  if (type == "drive") return DriveMessage{};
  if (type == "probe") return probe_from(j, rules);
  if (type == "map") return map_from(j);
  if (type == "snapshot") return snapshot_from(j, rules);
  if (type == "errors") return FileMessage{whole(j, "id"), scene_of(j, rules), false, {}, {}, true};
  if (type == "movie_frame") return movie_frame_from(j, rules);
  if (type == "part") return part_from(j, rules);
  if (type == "cancel") return CancelMessage{whole(j, "id")};
  if (type == "steer") return steer_from(j);
  throw InputError("the message's type is not known");
}

std::optional<std::uint32_t> id_of(std::string_view text) {
  try {
    return whole(parsed(text), "id");
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace serve
}  // namespace ringsplat
