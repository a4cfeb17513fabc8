#include "formats/nrrd/plain_nrrd.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/left_out.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "formats/text_source.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::size_t longest_header = 1 << 20;  // bytes; a header has a few hundred

/// The fields of one file's header ("Definition of NRRD File Format", teem.sourceforge.net/nrrd).
class Header {
 public:
  explicit Header(const std::filesystem::path& path) : path_(path), text_(beginning_of(path)) {
    const auto magic = take_line();
    if (!magic || !magic->starts_with("NRRD000"))
      throw InputError(fmt::format("{} does not begin with the letters NRRD", path.string()),
                       "rename it to its own format's ending");
    for (auto line = take_line(); line && !line->empty(); line = take_line()) take_field(*line);
  }

  const std::filesystem::path& path() const { return path_; }
  /// The byte behind the empty line, or behind the file.
  std::uint64_t end() const { return at_; }

  /// Empty when it is missing. `name` in small letters without blanks.
  std::string value(const std::string& name) const {
    const auto found = fields_.find(name);
    return found == fields_.end() ? std::string() : found->second;
  }

  [[noreturn]] void fail(const std::string& field) const {
    throw InputError(fmt::format("{}: the header's {} is '{}'", path_.string(), field,
                                 excerpt(value(without_blanks(field)))),
                     "see teem.sourceforge.net/nrrd for the format");
  }
  [[noreturn]] void refuse(const std::string& what) const {
    refuse_left_out(path_, "NRRD with " + what, "ITK");
  }

  /// A whole number from `least` on.
  std::int64_t number(const std::string& field, std::int64_t least, std::int64_t otherwise) const {
    const std::string text = value(without_blanks(field));
    if (text.empty()) return otherwise;
    const auto number = number_in<std::int64_t>(text);
    if (!number || *number < least) fail(field);
    return *number;
  }

 private:
  static std::string beginning_of(const std::filesystem::path& path) {
    const InputFile file(path);
    std::string text(std::size_t(std::min<std::uint64_t>(file.size(), longest_header)), '\0');
    file.read(0, std::as_writable_bytes(std::span(text)));
    return text;
  }
  static std::string without_blanks(std::string name) {
    std::erase(name, ' ');
    return name;
  }

  /// Without the line break; nothing at the end of the text.
  std::optional<std::string> take_line() {
    if (at_ >= text_.size()) return {};
    const auto newline = std::min(text_.find('\n', at_), text_.size());
    std::string line = text_.substr(at_, newline - at_);
    at_ = std::min(newline + 1, text_.size());
    if (line.ends_with('\r')) line.pop_back();
    return line;
  }

  void take_field(const std::string& line) {
    if (line.starts_with('#')) return;
    const auto colon = line.find(':');
    if (colon == std::string::npos)
      throw InputError(fmt::format("{}: '{}' is no line of a header", path_.string(), excerpt(line)),
                       "see teem.sourceforge.net/nrrd for the format");
    if (line.compare(colon, 2, ":=") == 0) return;  // key and value, which mean nothing here
    fields_[without_blanks(lower_case(trimmed(line.substr(0, colon))))] = trimmed(line.substr(colon + 1));
  }

  std::filesystem::path path_;
  std::string text_;
  std::size_t at_ = 0;
  std::map<std::string, std::string> fields_;
};

ScalarType type_of(const Header& header) {
  constexpr std::array<std::pair<std::string_view, ScalarType>, 8> others{
      {{"signed char", ScalarType::int8},
       {"int8_t", ScalarType::int8},
       {"uchar", ScalarType::uint8},
       {"short int", ScalarType::int16},
       {"signed short", ScalarType::int16},
       {"signed short int", ScalarType::int16},
       {"unsigned short int", ScalarType::uint16},
       {"signed int", ScalarType::int32}}};
  const std::string name = lower_case(header.value("type"));
  for (const auto& [other, type] : others)
    if (name == other) return type;
  try {
    return scalar_type_from(name);
  } catch (const InputError&) {
    header.fail("type");
  }
}

/// "(1,2,3)" with at most three numbers; the rest is 0. Nothing when it is no vector.
std::optional<glm::dvec3> vector_in(const std::string& text) {
  if (text.size() < 2 || text.front() != '(' || text.back() != ')') return {};
  glm::dvec3 v(0);
  int count = 0;
  const std::string inside = text.substr(1, text.size() - 2);
  for (std::size_t at = 0; at <= inside.size(); ++count) {
    const auto comma = std::min(inside.find(',', at), inside.size());
    const auto number = number_in<double>(trimmed(inside.substr(at, comma - at)));
    if (!number || !std::isfinite(*number) || count == 3) return {};
    v[count] = *number;
    at = comma + 1;
  }
  return v;
}

/// The vectors of a field, between whose numbers there may be blanks; "none" is one, too.
std::vector<std::string> vectors_of(const std::string& text) {
  std::vector<std::string> vectors;
  bool inside = false;
  for (const std::string& word : words_of(text)) {
    if (inside)
      vectors.back() += word;
    else
      vectors.push_back(word);
    inside = vectors.back().front() == '(' && vectors.back().back() != ')';
  }
  return vectors;
}

struct Space {
  glm::dvec3 to_lps{1};
  bool patient = false;
};

Space space_of(const Header& header) {
  const std::string name = lower_case(header.value("space"));
  if (name == "left-posterior-superior" || name == "lps") return {.patient = true};
  if (name == "right-anterior-superior" || name == "ras") return {{-1, -1, 1}, true};
  if (name == "left-anterior-superior" || name == "las") return {{1, -1, 1}, true};
  if (name.ends_with("-time") || name == "lpst" || name == "rast" || name == "last")
    header.refuse("a space of time");
  return {};
}

void require_lattice_axes(const Header& header, std::int64_t dimension) {
  if (dimension > 3) header.refuse(fmt::format("{} axes", dimension));
  for (const std::string& kind : words_of(lower_case(header.value("kinds"))))
    if (kind != "domain" && kind != "space" && kind != "???")
      header.refuse("an axis of kind " + excerpt(kind));
  // Where voxels lie would need the rules of nodes and cells.
  if (!header.value("axismins").empty()) header.refuse("axis mins");
}

void set_directions(const Header& header, int dimension, const Space& space, Grid& grid) {
  const auto directions = vectors_of(header.value("spacedirections"));
  if (directions.size() != std::size_t(dimension)) header.fail("space directions");
  for (int i = 0; i < dimension; ++i) {
    if (directions[std::size_t(i)] == "none") header.refuse("an axis without a direction");
    const auto direction = vector_in(directions[std::size_t(i)]);
    if (!direction || glm::length(*direction) == 0) header.fail("space directions");
    const auto& v = *direction;
    grid.spacing[i] = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    for (int k = 0; k < 3; ++k) grid.direction[i][k] = v[k] * (1.0 / grid.spacing[i]) * space.to_lps[k];
  }
  if (dimension == 2 && grid.direction[0].z + grid.direction[1].z != 0)
    grid.direction[2] = glm::normalize(glm::cross(grid.direction[0], grid.direction[1]));
}

void set_spacings(const Header& header, int dimension, Grid& grid) {
  const auto spacings = words_of(header.value("spacings"));
  if (spacings.empty()) return;
  if (spacings.size() != std::size_t(dimension)) header.fail("spacings");
  for (int i = 0; i < dimension; ++i) {
    const auto spacing = number_in<double>(lower_case(spacings[std::size_t(i)]));
    if (!spacing) header.fail("spacings");
    if (!std::isnan(*spacing)) grid.spacing[i] = *spacing;
  }
}

Grid grid_of(const Header& header, const Space& space) {
  const auto dimension = header.number("dimension", 1, 0);
  if (dimension == 0) header.fail("dimension");
  require_lattice_axes(header, dimension);
  Grid grid;
  grid.type = type_of(header);
  grid.dims = glm::ivec3(1);
  const auto sizes = words_of(header.value("sizes"));
  if (std::int64_t(sizes.size()) != dimension) header.fail("sizes");
  for (int i = 0; i < int(dimension); ++i) {
    const auto size = number_in<int>(sizes[std::size_t(i)]);
    if (!size || *size < 1) header.fail("sizes");
    grid.dims[i] = *size;
  }
  if (!header.value("spacedirections").empty())
    set_directions(header, int(dimension), space, grid);
  else
    set_spacings(header, int(dimension), grid);
  if (const std::string text = header.value("spaceorigin"); !text.empty()) {
    const auto vectors = vectors_of(text);
    const auto origin = vectors.size() == 1 ? vector_in(vectors[0]) : std::nullopt;
    if (!origin) header.fail("space origin");
    grid.origin = *origin * space.to_lps;
  }
  check_lattice(grid, header.path().string());
  return grid;
}

/// The byte behind so many lines.
std::uint64_t behind_lines(const std::filesystem::path& path, std::uint64_t offset, std::int64_t lines) {
  const InputFile file(path);
  std::array<std::byte, 4096> part{};
  while (lines > 0) {
    const auto got = file.read_some(offset, part);
    if (got == 0) require_bytes(path, file.size(), offset, 1);
    for (std::size_t k = 0; k < got && lines > 0; ++k, ++offset)
      if (part[k] == std::byte{'\n'}) --lines;
  }
  return offset;
}

bool is_big_endian(const Header& header, const Grid& grid) {
  const std::string endian = lower_case(header.value("endian"));
  if (endian == "big") return true;
  if (endian != "little" && (size_of(grid.type) > 1 || !endian.empty())) header.fail("endian");
  return false;
}

std::unique_ptr<VolumeSource> source_of(const Header& header, const Grid& grid) {
  const std::string name = header.value("datafile");
  if (name.starts_with("LIST") || name.find('%') != std::string::npos) header.refuse("several data files");
  const auto file = name.empty() ? header.path() : header.path().parent_path() / name;
  auto offset = behind_lines(file, name.empty() ? header.end() : 0, header.number("line skip", 0, 0));
  const auto skip = header.number("byte skip", -1, 0);
  const std::string encoding = lower_case(header.value("encoding"));
  const bool gzip = encoding == "gzip" || encoding == "gz",
             text = encoding == "ascii" || encoding == "text" || encoding == "txt";
  if (encoding != "raw" && !gzip && !text) {
    if (encoding == "hex") header.refuse("encoding hex");
    header.fail("encoding");
  }
  if (skip < 0 && encoding != "raw") header.fail("byte skip");
  const auto size = InputFile(file).size();
  if (skip < 0)
    offset = size - std::min(size, grid.bytes());
  else if (!gzip)
    offset += std::uint64_t(skip);
  if (text) return text_source(grid, file, offset);
  return stored_source(grid, {.file = file,
                              .offset = offset,
                              .compressed = gzip,
                              .skip = gzip ? std::uint64_t(skip) : 0,
                              .big_endian = is_big_endian(header, grid),
                              .type = grid.type});
}

}  // namespace

std::unique_ptr<VolumeSource> open_plain_nrrd(const std::filesystem::path& path) {
  const Header header(path);
  const Space space = space_of(header);
  const Grid grid = grid_of(header, space);
  return with_notes(source_of(header, grid),
                    space.patient ? VolumeNotes{.world = World::patient, .unit = "mm"} : VolumeNotes{});
}

}  // namespace ringsplat::detail
