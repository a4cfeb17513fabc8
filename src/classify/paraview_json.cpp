#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "classify/paraview_curves.hpp"
#include "classify/piecewise.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/classify/transfer_function.hpp"

namespace ringsplat {
namespace {

using Json = nlohmann::json;

constexpr const char* format_hint = "give a colour map as ParaView exports it (.json)";
constexpr std::size_t most_bytes = std::size_t(64) << 20;  // larger than any colour map
constexpr int samples_each_colour_span = 32;

/// The one colour map of the document.
Json parse_map(const std::string& text, const std::string& where) {
  Json document;
  try {
    document = Json::parse(text);
  } catch (const Json::exception& error) {
    const char* message = std::strstr(error.what(), "] ");  // after the library's own error name
    throw InputError(fmt::format("{} is not JSON: {}", where, message ? message + 2 : error.what()),
                     format_hint);
  }
  if (document.is_array()) {
    if (document.size() != 1)
      throw InputError(fmt::format("{} holds {} colour maps", where, document.size()),
                       "keep the one to be used in the list");
    Json only = std::move(document[0]);
    document = std::move(only);
  }
  if (!document.is_object()) throw InputError(fmt::format("{} holds no colour map", where), format_hint);
  return document;
}

bool is_missing(const Json& map, const char* field) {
  return !map.contains(field) || map.at(field).is_null();
}

/// A flat list of finite numbers, `group` of them a point.
std::vector<double> numbers(const Json& map, const char* field, std::size_t group, const std::string& where) {
  const Json& list = map.at(field);
  if (!list.is_array()) throw InputError(fmt::format("{}, {}: is not a list", where, field), format_hint);
  std::vector<double> out;
  for (const Json& item : list) {
    if (!item.is_number() || !std::isfinite(item.get<double>()))
      throw InputError(fmt::format("{}, {}: entry {} is not a number: {}", where, field, out.size() + 1,
                                   item.dump(-1, ' ', true, Json::error_handler_t::replace).substr(0, 40)),
                       "give finite numbers");
    out.push_back(item.get<double>());
  }
  if (out.size() % group != 0)
    throw InputError(
        fmt::format("{}, {}: {} numbers are not a multiple of {}", where, field, out.size(), group),
        group == 4 && field[0] == 'R' ? "give value, red, green, blue for each point"
        : group == 4                  ? "give value, opacity, midpoint, sharpness for each point"
                                      : "give red, green, blue");
  return out;
}

std::string text_field(const Json& map, const char* field, const std::string& otherwise,
                       const std::string& where) {
  if (is_missing(map, field)) return otherwise;
  if (!map.at(field).is_string())
    throw InputError(fmt::format("{}, {}: is not a text", where, field), format_hint);
  return map.at(field).get<std::string>();
}

std::vector<TransferFunction::ColourPoint> read_colours(const Json& map, const std::string& where) {
  if (is_missing(map, "RGBPoints"))
    throw InputError(fmt::format("{} has no RGBPoints", where),
                     map.contains("IndexedColors")
                         ? "a map of indexed colours cannot be used; give one over values"
                         : format_hint);
  std::vector<TransferFunction::ColourPoint> points;
  const auto flat = numbers(map, "RGBPoints", 4, where);
  for (std::size_t i = 0; i < flat.size(); i += 4)
    points.push_back({flat[i], {flat[i + 1], flat[i + 2], flat[i + 3]}});
  return points;
}

std::vector<TransferFunction::OpacityPoint> read_opacities(const Json& map, std::vector<CurveShape>& shapes,
                                                           const std::string& where) {
  std::vector<TransferFunction::OpacityPoint> points;
  const auto flat = numbers(map, "Points", 4, where);
  for (std::size_t i = 0; i < flat.size(); i += 4) {
    points.push_back({flat[i], flat[i + 1]});
    shapes.push_back({flat[i + 2], flat[i + 3]});
    for (const double share : {flat[i + 2], flat[i + 3]})
      if (share < 0 || share > 1)
        throw InputError(fmt::format("{}, Points: midpoint or sharpness {} of point {} is outside 0..1",
                                     where, share, points.size()),
                         "0.5 and 0 are the neutral ones");
  }
  return points;
}

/// Null for RGB.
ColourCurve read_colour_curve(const Json& map, const std::string& where) {
  const std::string name = text_field(map, "ColorSpace", "RGB", where);
  if (name == "RGB") return nullptr;
  const bool wrap = !is_missing(map, "HSVWrap") && (map["HSVWrap"] == true || map["HSVWrap"] == 1);
  if (const ColourCurve curve = colour_curve(name, wrap)) return curve;
  throw InputError(fmt::format("{}, ColorSpace: \"{}\" is not known", where, name),
                   "use RGB, HSV, Lab or Diverging, or export the map from ParaView as RGB");
}

/// Samples display colours along a way in another space, close enough together to be interpolated in RGB.
std::vector<TransferFunction::ColourPoint> sample_colours(
    const std::vector<TransferFunction::ColourPoint>& points, ColourCurve curve) {
  return with_more(points, [&](auto& out, std::size_t i) {
    for (int k = 1; k < samples_each_colour_span; ++k) {
      const double t = double(k) / samples_each_colour_span;
      out.push_back({std::lerp(points[i].value, points[i + 1].value, t),
                     glm::clamp(curve(points[i].srgb, points[i + 1].srgb, t), 0.0, 1.0)});
    }
  });
}

}  // namespace

TransferFunction parse_transfer_function(const std::string& json, const std::string& where, bool* ramp) {
  const Json map = parse_map(json, where);
  TransferFunction tf;
  std::vector<CurveShape> shapes;
  tf.name = text_field(map, "Name", tf.name, where);
  tf.colours = read_colours(map, where);
  const bool no_opacities = is_missing(map, "Points");
  if (!no_opacities) {
    tf.opacities = read_opacities(map, shapes, where);
  } else if (!tf.colours.empty()) {
    tf.opacities = {{tf.colours.front().value, 0.0}, {tf.colours.back().value, 1.0}};
    shapes.resize(tf.opacities.size());
  }
  if (ramp != nullptr) *ramp = no_opacities;
  if (!is_missing(map, "NanColor")) {
    const auto c = numbers(map, "NanColor", 3, where);
    if (c.size() != 3)
      throw InputError(fmt::format("{}, NanColor: is not one colour", where), "give red, green, blue");
    tf.nan_srgb = {c[0], c[1], c[2]};
  }
  const ColourCurve curve = read_colour_curve(map, where);
  check(tf, where);
  if (curve != nullptr) tf.colours = sample_colours(tf.colours, curve);
  tf.opacities = sample_shapes(tf.opacities, shapes);
  return tf;
}

TransferFunction read_transfer_function(const std::filesystem::path& file, bool* ramp) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored))
    throw InputError(fmt::format("there is no transfer function {}", file.string()),
                     "give a preset's name or a ParaView colour map (.json)");
  if (std::filesystem::is_directory(file, ignored))
    throw InputError(fmt::format("transfer function {} is a folder", file.string()), format_hint);
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw InputError(fmt::format("transfer function {} cannot be opened", file.string()),
                     "check its permissions");
  std::string text(most_bytes + 1, '\0');
  in.read(text.data(), std::streamsize(text.size()));
  if (in.bad())
    throw InputError(fmt::format("transfer function {} cannot be read", file.string()), format_hint);
  text.resize(std::size_t(in.gcount()));
  if (text.size() > most_bytes)
    throw InputError(fmt::format("transfer function {} is larger than 64 MiB", file.string()), format_hint);
  return parse_transfer_function(text, file.string(), ramp);
}

std::string to_paraview_json(const TransferFunction& tf) {
  Json map;
  map["ColorSpace"] = "RGB";
  map["Name"] = tf.name;
  map["NanColor"] = {tf.nan_srgb.x, tf.nan_srgb.y, tf.nan_srgb.z};
  Json& colours = map["RGBPoints"] = Json::array();
  for (const auto& p : tf.colours)
    for (const double v : {p.value, p.srgb.x, p.srgb.y, p.srgb.z}) colours.push_back(v);
  Json& opacities = map["Points"] = Json::array();
  const CurveShape neutral;
  for (const auto& p : tf.opacities)
    for (const double v : {p.value, p.opacity, neutral.midpoint, neutral.sharpness}) opacities.push_back(v);
  return Json::array({map}).dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace ringsplat
