#include "app/views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/option_values.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

using nlohmann::json;

struct Field {
  const char* name;
  double Camera::*part;
};
constexpr Field fields[] = {{"azimuth", &Camera::azimuth},
                            {"elevation", &Camera::elevation},
                            {"roll", &Camera::roll},
                            {"zoom", &Camera::zoom}};

constexpr const char* line_hint =
    "a line is: azimuth elevation [roll [zoom]], or JSON such as {\"azimuth\": 30, \"zoom\": 2}";

double Camera::*field_named(const std::string& name) {
  for (const auto& field : fields)
    if (name == field.name) return field.part;
  return nullptr;
}

/// The columns that a heading names; empty when the line is no heading.
std::vector<double Camera::*> columns_of(std::string line) {
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
  std::istringstream words(line);
  std::vector<double Camera::*> columns;
  for (std::string word; words >> word;) {
    std::transform(word.begin(), word.end(), word.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto part = field_named(word);
    if (part == nullptr) return {};
    columns.push_back(part);
  }
  return columns;
}

Camera from_json(const std::string& line, const std::string& where, Camera camera) {
  const json j = json::parse(line, nullptr, false);
  if (!j.is_object()) throw InputError(fmt::format("{}: this is not a JSON object", where), line_hint);
  for (const auto& [key, value] : j.items()) {
    if (key == "matrix" && value.is_array() && value.size() == 12 &&
        std::all_of(value.begin(), value.end(), [](const json& n) { return n.is_number(); })) {
      camera.matrix = value.get<std::array<double, 12>>();
    } else if (const auto part = field_named(key); part != nullptr && value.is_number()) {
      camera.*part = value.get<double>();
    } else {
      throw InputError(
          fmt::format("{}: '{}' is not azimuth, elevation, roll or zoom with a number, nor matrix with 12",
                      where, key),
          line_hint);
    }
  }
  return camera;
}

Camera from_columns(const std::string& line, const std::string& where,
                    const std::vector<double Camera::*>& columns, Camera camera) {
  const auto numbers = parse_numbers(line);
  if (!numbers || numbers->empty() || numbers->size() > columns.size())
    throw InputError(fmt::format("{}: '{}' is not 1 to {} numbers", where, line, columns.size()), line_hint);
  for (std::size_t k = 0; k < numbers->size(); ++k) camera.*columns[k] = (*numbers)[k];
  return camera;
}

}  // namespace

std::vector<Camera> orbit(const Camera& start, int frames) {
  std::vector<Camera> cameras(static_cast<std::size_t>(frames), start);
  for (int k = 0; k < frames; ++k) cameras[std::size_t(k)].azimuth = start.azimuth + 360.0 * k / frames;
  return cameras;
}

std::vector<Camera> parse_path(const std::string& text, const std::string& where, const Camera& defaults) {
  std::vector<double Camera::*> columns;
  for (const auto& field : fields) columns.push_back(field.part);
  std::vector<Camera> cameras;
  std::istringstream in(text);
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const auto first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') continue;
    const std::string here = fmt::format("{}:{}", where, number);
    while (line.ends_with('\r') || line.ends_with(' ')) line.pop_back();
    if (const auto named = columns_of(line); !named.empty() && cameras.empty())
      columns = named;
    else
      cameras.push_back(line[first] == '{' ? from_json(line, here, defaults)
                                           : from_columns(line, here, columns, defaults));
  }
  if (cameras.empty()) throw InputError(fmt::format("{}: there is no view in it", where), line_hint);
  return cameras;
}

std::vector<Camera> read_path(const std::filesystem::path& file, const Camera& defaults) {
  std::ifstream in(file, std::ios::binary);
  // A folder opens like a file, but nothing can be read from it.
  if (!in || std::filesystem::is_directory(file))
    throw InputError(fmt::format("--path {} cannot be read", file.string()), line_hint);
  std::ostringstream text;
  text << in.rdbuf();
  return parse_path(text.str(), file.string(), defaults);
}

std::filesystem::path numbered(const std::filesystem::path& file, std::size_t index) {
  return file.parent_path() /
         fmt::format("{}-{:04}{}", file.stem().string(), index, file.extension().string());
}

}  // namespace ringsplat::app
