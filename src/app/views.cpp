#include "app/views.hpp"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

using nlohmann::json;

constexpr const char* path_line_hint =
    "a line is: azimuth elevation [roll [zoom]], or JSON such as {\"azimuth\": 30, \"zoom\": 2}";

constexpr std::pair<const char*, double Camera::*> fields[] = {
    {"azimuth", &Camera::azimuth}, {"elevation", &Camera::elevation},
    {"roll", &Camera::roll},       {"zoom", &Camera::zoom},
    {"fov", &Camera::fov},         {"distance", &Camera::distance}};
constexpr std::size_t usual_columns = 4;

double Camera::*field_named(const std::string& name) { return detail::found(fields, name).value_or(nullptr); }

/// The columns that a heading line names; empty when the line is no heading.
std::vector<double Camera::*> columns_of(std::string line) {
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
  std::vector<double Camera::*> columns;
  for (const std::string& word : detail::words_of(detail::lower_case(line))) {
    const auto part = field_named(word);
    if (part == nullptr) return {};
    columns.push_back(part);
  }
  return columns;
}

Camera from_json(const std::string& line, const std::string& where, Camera camera) {
  const json j = json::parse(line, nullptr, false);
  if (!j.is_object()) throw InputError(fmt::format("{}: this is not a JSON object", where), path_line_hint);
  for (const auto& [key, value] : j.items()) {
    if (key == "matrix" && value.is_array() && value.size() == 12 &&
        std::all_of(value.begin(), value.end(), [](const json& n) { return n.is_number(); })) {
      camera.matrix = value.get<std::array<double, 12>>();
    } else if (const auto part = field_named(key); part != nullptr && value.is_number()) {
      camera.*part = value.get<double>();
    } else {
      throw InputError(fmt::format("{}: '{}' is not azimuth, elevation, roll, zoom, fov or distance with a "
                                   "number, nor matrix with 12",
                                   where, excerpt(key)),
                       path_line_hint);
    }
  }
  return camera;
}

Camera from_columns(const std::string& line, const std::string& where,
                    const std::vector<double Camera::*>& columns, Camera camera) {
  const auto numbers = parse_numbers(line);
  if (!numbers || numbers->empty() || numbers->size() > columns.size())
    throw InputError(fmt::format("{}: '{}' is not 1 to {} numbers", where, excerpt(line), columns.size()),
                     path_line_hint);
  for (std::size_t k = 0; k < numbers->size(); ++k) camera.*columns[k] = (*numbers)[k];
  return camera;
}

/// Reads a path line by line.
class PathReader {
 public:
  explicit PathReader(const Camera& defaults) : defaults_(defaults) {
    for (const auto& field : std::span(fields).first(usual_columns)) columns_.push_back(field.second);
  }

  /// The line's view, if it gives one. Throws InputError that begins with `where` and shows an excerpt.
  std::optional<Camera> read(std::string line, const std::string& where) {
    const auto first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') return std::nullopt;
    while (line.ends_with('\r') || line.ends_with(' ')) line.pop_back();
    if (const auto named = columns_of(line); !named.empty() && !view_came_) {
      columns_ = named;
      return std::nullopt;
    }
    const Camera view = line[first] == '{' ? from_json(line, where, defaults_)
                                           : from_columns(line, where, columns_, defaults_);
    if (!(view.zoom > 0))
      throw InputError(fmt::format("{}: the zoom {:g} is not positive", where, view.zoom), path_line_hint);
    view_came_ = true;
    return view;
  }

 private:
  Camera defaults_;
  std::vector<double Camera::*> columns_;
  bool view_came_ = false;
};

std::vector<Camera> read_path(const std::filesystem::path& file, const Camera& defaults) {
  std::ifstream in(file, std::ios::binary);
  // A folder opens like a file, but nothing can be read from it.
  if (!in || std::filesystem::is_directory(file))
    throw InputError(fmt::format("--path {} cannot be read", file.string()), path_line_hint);
  return parse_path(in, file.string(), defaults);
}

}  // namespace

std::vector<Camera> orbit(const Camera& start, int frames) {
  std::vector<Camera> cameras(static_cast<std::size_t>(frames), start);
  for (int k = 0; k < frames; ++k) cameras[std::size_t(k)].azimuth = start.azimuth + 360.0 * k / frames;
  return cameras;
}

std::vector<Camera> parse_path(std::istream& in, const std::string& where, const Camera& defaults) {
  constexpr std::size_t most_bytes = 4096;
  PathReader reader(defaults);
  std::vector<Camera> cameras;
  std::array<char, most_bytes + 2> text{};
  auto place = [&, number = 0]() mutable { return fmt::format("{}:{}", where, ++number); };
  while (in.getline(text.data(), text.size())) {
    const std::string line(text.data(), std::size_t(in.gcount()) - (in.eof() ? 0 : 1));
    const auto view = reader.read(line, place());
    if (!view) continue;
    if (cameras.size() == most_views)
      throw InputError(fmt::format("{}: there are more than {} views in it", where, most_views),
                       "render it in parts");
    cameras.push_back(*view);
  }
  if (in.bad())
    throw InputError(fmt::format("{} cannot be read to its end", where),
                     "is the disk or the network at fault?");
  if (!in.eof())
    throw InputError(
        fmt::format("{}: '{}' has more than {} bytes", place(), excerpt(text.data()), most_bytes),
        path_line_hint);
  if (cameras.empty()) throw InputError(fmt::format("{}: there is no view in it", where), path_line_hint);
  return cameras;
}

std::vector<Camera> views_of(const RenderOptions& o) {
  const Camera& start = o.frame.shown.camera;
  if (o.orbit > 0) return orbit(start, o.orbit);
  if (o.path == "-") {
    std::ios::sync_with_stdio(false);  // else std::cin takes an error for the end
    return parse_path(std::cin, "--path -", start);
  }
  if (!o.path.empty()) return read_path(o.path, start);
  std::vector<Camera> cameras(std::max<std::size_t>(1, o.views.size()), start);
  constexpr double Camera::*parts[] = {&Camera::azimuth, &Camera::elevation, &Camera::roll, &Camera::zoom};
  for (std::size_t k = 0; k < o.views.size(); ++k)
    for (std::size_t p = 0; p < std::size(parts); ++p)
      cameras[k].*parts[p] = o.views[k][p].value_or(start.*parts[p]);
  return cameras;
}

std::filesystem::path numbered(const std::filesystem::path& file, std::size_t index) {
  return file.parent_path() /
         fmt::format("{}-{:04}{}", file.stem().string(), index, file.extension().string());
}

}  // namespace ringsplat::app
