#include "formats/nrrd/header.hpp"

#include <glm/common.hpp>
#include <sstream>
#include <string_view>

#include "base/printable.hpp"
#include "base/text.hpp"
#include "formats/label_notes.hpp"
#include "formats/stored_source.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::uint64_t longest_header = 64 << 20;  // bytes; a header has a few hundred

/// As spelled() has them.
constexpr std::string_view known_fields =
    " content number type blocksize dimension space spacedimension sizes spacings thicknesses axismins "
    "axismaxs spacedirections centerings kinds labels units min max oldmin oldmax endian encoding lineskip "
    "byteskip sampleunits spaceunits spaceorigin measurementframe datafile ";

/// Fields, kinds and spaces are spelled with hyphens, blanks or neither, in any case.
std::string spelled(const std::string& text) {
  std::string name = lower_case(trimmed(text));
  std::erase_if(name, [](char c) { return c == '-' || c == ' '; });
  return name == "centers" ? "centerings" : name;
}

/// The lines "field: value" of an NRRD's header, and the names of data files behind its last line.
class NrrdFields {
 public:
  explicit NrrdFields(const std::filesystem::path& path) : path_(path) {
    const InputFile file(path);
    TextReader text(file, 0, longest_header);
    if (const auto magic = text.line(); !magic || !magic->starts_with("NRRD00"))
      fail_nrrd(path, "it does not begin with the letters NRRD and a version");
    for (auto line = text.line(); line && !line->empty(); line = text.line()) {
      if (value("data file").starts_with("LIST"))
        listed_.push_back(*line);
      else
        take(*line);
    }
    end_ = text.position();
    if (end_ >= longest_header) fail_nrrd(path, "its header does not end");
  }

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t end() const { return end_; }  ///< the byte behind the header
  /// "key:=value", which says nothing of the volume.
  const std::map<std::string, std::string>& pairs() const { return pairs_; }
  /// Behind "data file: LIST".
  const std::vector<std::string>& listed() const { return listed_; }

  /// Empty when it is missing. `field`: the first of its spellings, as in "data file".
  std::string value(const std::string& field) const {
    const auto found = values_.find(spelled(field));
    return found == values_.end() ? std::string() : found->second;
  }
  std::string required(const std::string& field) const {
    const auto text = value(field);
    if (text.empty()) fail_nrrd(path_, fmt::format("'{}' is missing", field));
    return text;
  }
  /// One word an axis; none when the field is missing.
  std::vector<std::string> words_of_axes(const std::string& field, std::size_t axes) const {
    const auto list = words_of(value(field));
    if (!list.empty() && list.size() != axes)
      fail_nrrd(path_, fmt::format("it has {} {}, but its dimension is {}", list.size(), field, axes));
    return list;
  }
  /// One number an axis, NaN where there is none; none when the field is missing.
  std::vector<double> numbers_of_axes(const std::string& field, std::size_t axes) const {
    return mapped(words_of_axes(field, axes), [&](const auto& word) { return number(word, field); });
  }
  /// The vectors "(1,2,3)" of as many finite numbers, empty ones for "none"; none when the field is missing.
  std::vector<std::vector<double>> vectors(const std::string& field, int axes_of_space) const {
    const std::string text = value(field);
    std::vector<std::vector<double>> list;
    for (std::string_view rest = text; !rest.empty();
         rest.remove_prefix(std::min(rest.find_first_not_of(" \t"), rest.size()))) {
      if (axes_of_space == 0) fail_nrrd(path_, fmt::format("its {} has no space, or space dimension", field));
      const bool none = rest.starts_with("none");
      const auto bytes = none ? 4 : rest.find(')') + 1;
      if (!none && (rest.front() != '(' || bytes == 0)) fail(field);
      auto& vector = list.emplace_back();
      if (!none) vector = vector_in(rest.substr(1, bytes - 2), field, axes_of_space);
      rest.remove_prefix(bytes);
    }
    return list;
  }
  std::int64_t integer(const std::string& field, std::int64_t otherwise) const {
    const auto text = value(field);
    if (text.empty()) return otherwise;
    const auto number = number_in<std::int64_t>(text);
    if (!number) fail(field);
    return *number;
  }
  [[noreturn]] void fail(const std::string& field) const {
    fail_nrrd(path_, fmt::format("its {} is '{}'", field, excerpt(value(field))));
  }

 private:
  void take(const std::string& line) {
    if (line.starts_with('#')) return;
    const auto colon = line.find(':');
    const auto field = spelled(line.substr(0, colon));
    const bool is_pair = line.find(":=") != std::string::npos;
    if (colon == std::string::npos || line.compare(colon, 2, ":=") == 0 ||
        known_fields.find(" " + field + " ") == std::string_view::npos) {
      if (is_pair) return void(pairs_[line.substr(0, colon)] = line.substr(colon + 2));
      fail_nrrd(path_, fmt::format("'{}' is no line of a header", excerpt(line)));
    }
    if (!values_.emplace(field, trimmed(line.substr(colon + 1))).second)
      fail_nrrd(path_, fmt::format("'{}' is given twice", excerpt(line.substr(0, colon))));
  }

  /// NaN where there is none.
  double number(const std::string& word, const std::string& field) const {
    const auto number = number_in<double>(lower_case(word));
    if (!number || std::isinf(*number)) fail(field);
    return *number;
  }

  std::vector<double> vector_in(std::string_view text, const std::string& field, int axes_of_space) const {
    auto vector = mapped(split(text, ","), [&](auto part) { return number(trimmed(part), field); });
    if (int(vector.size()) != axes_of_space) fail(field);
    const auto missing = std::count_if(vector.begin(), vector.end(), [](double v) { return std::isnan(v); });
    if (missing == axes_of_space) return {};
    if (missing > 0) fail(field);
    return vector;
  }

  std::filesystem::path path_;
  std::uint64_t end_ = 0;
  std::map<std::string, std::string> values_, pairs_;
  std::vector<std::string> listed_;
};

Encoding encoding_of(const NrrdFields& fields) {
  constexpr std::pair<std::string_view, Encoding> encodings[] = {
      {"raw", Encoding::raw},    {"gzip", Encoding::deflate}, {"gz", Encoding::deflate},
      {"ascii", Encoding::text}, {"text", Encoding::text},    {"txt", Encoding::text},
      {"hex", Encoding::hex}};
  const auto name = fields.required("encoding");
  if (const auto encoding = found(encodings, lower_case(name))) return *encoding;
  refuse(fields.path(), "write it anew with encoding gzip or raw", "encoding '{}' cannot be read",
         excerpt(name));
}

/// Vectors, matrices and the like are the kinds that are not named here.
NrrdKind kind_of(const std::string& name) {
  using enum NrrdKind;
  constexpr std::pair<std::string_view, NrrdKind> kinds[] = {
      {"???", unknown},    {"none", unknown}, {"domain", lattice},    {"space", lattice},
      {"time", time},      {"list", list},    {"rgb", colours},       {"rgbcolor", colours},
      {"3color", colours}, {"rgba", colours}, {"rgbacolor", colours}, {"4color", colours}};
  return found(kinds, spelled(name)).value_or(channels);
}

struct Space {
  std::string_view name, abbreviation;
  bool patient = false;
  glm::dvec3 to_lps{1};
};
constexpr Space spaces[] = {{"rightanteriorsuperior", "ras", true, {-1, -1, 1}},
                            {"leftanteriorsuperior", "las", true, {1, -1, 1}},
                            {"leftposteriorsuperior", "lps", true},
                            {"scannerxyz", "scannerxyz"},
                            {"3drighthanded", "3drighthanded"},
                            {"3dlefthanded", "3dlefthanded"}};

std::size_t dimension_of(const NrrdFields& fields) {
  fields.required("dimension");
  constexpr std::int64_t most = 16;
  const auto dimension = fields.integer("dimension", 0);
  if (dimension < 1 || dimension > most) fields.fail("dimension");
  return std::size_t(dimension);
}

int size_of_axis(const NrrdFields& fields, std::size_t axis, const std::string& word) {
  if (word.find_first_not_of("0123456789") != std::string::npos) fields.fail("sizes");
  const auto size = number_in<int>(word);
  if (!size)
    refuse(fields.path(), "correct the sizes in the header", "{} voxels along axis {}", excerpt(word), axis);
  if (*size == 0) fail_nrrd(fields.path(), fmt::format("axis {} size is zero", axis));
  return *size;
}

void read_sizes(const NrrdFields& fields, NrrdHeader& header) {
  constexpr auto most = std::uint64_t(std::numeric_limits<std::int64_t>::max());
  const auto words = fields.words_of_axes("sizes", dimension_of(fields));
  fields.required("sizes");
  std::uint64_t voxels = 1;
  for (const auto& word : words) {
    header.axes.emplace_back().size = size_of_axis(fields, header.axes.size(), word);
    const auto size = std::uint64_t(header.axes.back().size);
    if (voxels > most / size) fail_nrrd(fields.path(), "its sizes are too large, they overflow 64 bits");
    voxels *= size;
  }
}

void read_kinds(const NrrdFields& fields, NrrdHeader& header) {
  const auto kinds = fields.words_of_axes("kinds", header.axes.size());
  for (std::size_t i = 0; i < kinds.size(); ++i) header.axes[i].kind = kind_of(kinds[i]);
  const auto centerings = fields.words_of_axes("centerings", header.axes.size());
  for (std::size_t i = 0; i < centerings.size(); ++i)
    header.axes[i].nodes = lower_case(centerings[i]) == "node";
}

void read_spacings(const NrrdFields& fields, NrrdHeader& header) {
  const auto count = header.axes.size();
  const std::pair<const char*, double NrrdAxis::*> lists[] = {
      {"spacings", &NrrdAxis::spacing}, {"axis mins", &NrrdAxis::min}, {"axis maxs", &NrrdAxis::max}};
  for (const auto& [field, member] : lists) {
    const auto numbers = fields.numbers_of_axes(field, count);
    for (std::size_t i = 0; i < numbers.size(); ++i) header.axes[i].*member = numbers[i];
  }
  for (std::size_t i = 0; i < count; ++i)
    if (header.axes[i].spacing == 0) fail_nrrd(fields.path(), fmt::format("axis {} spacing (0) invalid", i));
}

void read_space(const NrrdFields& fields, NrrdHeader& header) {
  constexpr std::int64_t most_axes = 8;
  const auto axes = fields.integer("space dimension", 0);
  if (axes < 0 || axes > most_axes) fields.fail("space dimension");
  header.space_axes = int(axes);
  const auto name = spelled(fields.value("space"));
  if (name.empty()) return;
  for (const auto& space : spaces)
    for (const bool time : {false, true}) {
      if (name != std::string(space.name) + (time ? "time" : "") &&
          name != std::string(space.abbreviation) + (time ? "t" : ""))
        continue;
      header.space_axes = time ? 4 : 3;
      header.patient = space.patient;
      header.to_lps = space.to_lps;
    }
  if (header.space_axes == 0 || (axes > 0 && axes != header.space_axes)) fields.fail("space");
}

void read_directions(const NrrdFields& fields, NrrdHeader& header) {
  const auto directions = fields.vectors("space directions", header.space_axes);
  if (!directions.empty() && directions.size() != header.axes.size()) fields.fail("space directions");
  for (std::size_t i = 0; i < directions.size(); ++i) {
    auto& axis = header.axes[i];
    axis.direction = directions[i];
    if (axis.direction.empty()) continue;
    if (!(axis.length() > 0) || !std::isfinite(axis.length())) fields.fail("space directions");
    if (!std::isnan(axis.spacing) || !std::isnan(axis.min) || !std::isnan(axis.max))
      fail_nrrd(fields.path(), fmt::format("axis {} has a space direction and spacing, min or max", i));
  }
  const auto origin = fields.vectors("space origin", header.space_axes);
  if (origin.size() > 1) fields.fail("space origin");
  if (!origin.empty()) header.origin = origin[0];
}

bool is_big_endian(const NrrdFields& fields, const NrrdHeader& header) {
  const auto endian = lower_case(fields.value("endian"));
  if (endian == "big") return true;
  if (endian.empty() && header.encoding != Encoding::text && size_of(header.type) > 1)
    fields.required("endian");
  if (endian != "little" && !endian.empty()) fields.fail("endian");
  return false;
}

void read_skips(const NrrdFields& fields, NrrdHeader& header) {
  header.line_skip = fields.integer("line skip", 0);
  header.byte_skip = fields.integer("byte skip", 0);
  constexpr std::int64_t farthest = std::int64_t{1} << 60;
  if (header.line_skip < 0) fields.fail("line skip");
  if (std::abs(header.byte_skip) > farthest || (header.byte_skip < 0 && header.encoding != Encoding::raw))
    fields.fail("byte skip");
}

}  // namespace

NrrdHeader read_nrrd_header(const std::filesystem::path& path) {
  const NrrdFields fields(path);
  NrrdHeader header;
  header.path = path;
  read_sizes(fields, header);
  header.type = voxel_type(path, fields.required("type"));
  read_kinds(fields, header);
  read_spacings(fields, header);
  read_space(fields, header);
  read_directions(fields, header);
  header.encoding = encoding_of(fields);
  header.big_endian = is_big_endian(fields, header);
  read_skips(fields, header);
  header.data_file = fields.value("data file");
  header.listed = fields.listed();
  if (header.data_file.empty()) header.end = fields.end();
  return header;
}

std::map<double, LabelNotes> nrrd_label_notes(const std::filesystem::path& file) {
  constexpr std::string_view of_value = "_LabelValue";
  constexpr std::size_t longest = 4096;
  std::map<double, LabelNotes> notes;
  const NrrdFields fields(file);
  for (const auto& [key, text] : fields.pairs()) {
    if (!key.starts_with("Segment") || !key.ends_with(of_value)) continue;
    const auto said = [&](const char* what) {
      const auto pair = fields.pairs().find(key.substr(0, key.size() - of_value.size()) + what);
      return pair != fields.pairs().end() && pair->second.size() < longest ? pair->second : std::string();
    };
    const auto value = number_in<double>(trimmed(text));
    LabelNotes label{printable(said("_Name")), {}};
    std::istringstream colour(said("_Color"));
    if (glm::dvec3 rgb; colour >> rgb.r >> rgb.g >> rgb.b) label.colour = glm::clamp(rgb, 0.0, 1.0);
    if (value && (label.colour || !label.name.empty())) notes[*value] = std::move(label);
  }
  return notes;
}

}  // namespace ringsplat::detail
