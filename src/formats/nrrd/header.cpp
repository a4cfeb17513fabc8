#include "formats/nrrd/header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "base/text.hpp"
#include "formats/nrrd/fields.hpp"
#include "formats/numbered_name.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

template <class T, std::size_t count>
std::optional<T> found(const std::pair<std::string_view, T> (&list)[count], const std::string& name) {
  for (const auto& [known, value] : list)
    if (known == name) return value;
  return {};
}

std::optional<ScalarType> type_named(const std::string& name) {
  constexpr std::pair<std::string_view, ScalarType> others[] = {{"signed char", ScalarType::int8},
                                                                {"int8_t", ScalarType::int8},
                                                                {"uchar", ScalarType::uint8},
                                                                {"short int", ScalarType::int16},
                                                                {"signed short", ScalarType::int16},
                                                                {"signed short int", ScalarType::int16},
                                                                {"unsigned short int", ScalarType::uint16},
                                                                {"signed int", ScalarType::int32}};
  if (const auto type = found(others, lower_case(name))) return type;
  try {
    return scalar_type_from(name);
  } catch (const InputError&) {
    return {};
  }
}

ScalarType type_of(const NrrdFields& fields) {
  const auto name = fields.required("type");
  if (const auto type = type_named(name)) return *type;
  throw InputError(
      fmt::format("{}: voxels of type '{}' cannot be rendered", fields.path().string(), excerpt(name)),
      "convert them to int32, uint32 or float32 first");
}

NrrdEncoding encoding_of(const NrrdFields& fields) {
  constexpr std::pair<std::string_view, NrrdEncoding> encodings[] = {
      {"raw", NrrdEncoding::raw},    {"gzip", NrrdEncoding::gzip}, {"gz", NrrdEncoding::gzip},
      {"ascii", NrrdEncoding::text}, {"text", NrrdEncoding::text}, {"txt", NrrdEncoding::text},
      {"hex", NrrdEncoding::hex}};
  const auto name = fields.required("encoding");
  if (const auto encoding = found(encodings, lower_case(name))) return *encoding;
  throw InputError(fmt::format("{}: encoding '{}' cannot be read", fields.path().string(), excerpt(name)),
                   "write it anew with encoding gzip or raw");
}

/// Kinds and spaces are spelled with hyphens, blanks or neither, in any case.
std::string joined(std::string name) {
  std::erase_if(name, [](char c) { return c == '-' || c == ' '; });
  return lower_case(std::move(name));
}

/// Vectors, matrices and the like are the kinds that are not named here.
NrrdKind kind_of(const std::string& name) {
  using enum NrrdKind;
  constexpr std::pair<std::string_view, NrrdKind> kinds[] = {
      {"???", unknown},    {"none", unknown}, {"domain", lattice},    {"space", lattice},
      {"time", time},      {"list", list},    {"rgb", colours},       {"rgbcolor", colours},
      {"3color", colours}, {"rgba", colours}, {"rgbacolor", colours}, {"4color", colours}};
  return found(kinds, joined(name)).value_or(channels);
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
    throw InputError(fmt::format("{}: {} voxels along axis {}", fields.path().string(), excerpt(word), axis),
                     "correct the sizes in the header");
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
  const auto name = joined(fields.value("space"));
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
  if (endian.empty() && header.encoding != NrrdEncoding::text && size_of(header.type) > 1)
    fields.required("endian");
  if (endian != "little" && !endian.empty()) fields.fail("endian");
  return false;
}

void read_skips(const NrrdFields& fields, NrrdHeader& header) {
  header.line_skip = fields.integer("line skip", 0);
  header.byte_skip = fields.integer("byte skip", 0);
  constexpr std::int64_t farthest = std::int64_t{1} << 60;
  if (header.line_skip < 0) fields.fail("line skip");
  if (std::abs(header.byte_skip) > farthest || (header.byte_skip < 0 && header.encoding != NrrdEncoding::raw))
    fields.fail("byte skip");
}

using Names = std::vector<std::string>;

bool is_pattern(const std::string& name) {
  for (auto at = name.find('%'); at != std::string::npos; at = name.find('%', at + 1)) {
    const auto letter = name.find_first_not_of("0123456789", at + 1);
    if (letter != std::string::npos && name[letter] == 'd') return true;
  }
  return false;
}

/// How many files there must be, for pieces of as many axes; by default of all but the last.
void require_count(const NrrdFields& fields, const std::vector<NrrdAxis>& axes, std::size_t count,
                   const std::optional<std::string>& piece) {
  const auto given = piece ? number_in<std::size_t>(*piece) : axes.size() - 1;
  if (!given || *given > axes.size() || (piece && *given == 0)) fields.fail("data file");
  std::uint64_t expected = 1;
  for (auto i = *given; i < axes.size(); ++i) expected *= std::uint64_t(axes[i].size);
  const bool fits =
      *given == axes.size() ? count > 0 && std::size_t(axes.back().size) % count == 0 : count == expected;
  if (!fits)
    fail_nrrd(fields.path(), fmt::format("it names {} data files, which do not fit its sizes", count));
}

Names names_of_pattern(const NrrdFields& fields, const std::vector<NrrdAxis>& axes) {
  const auto words = fields.words("data file");
  const NumberedName name(words[0]);
  if (!name.valid())
    throw InputError(fmt::format("{}: the pattern of its data files is '{}'", fields.path().string(),
                                 excerpt(fields.value("data file"))),
                     "give a name with one number, such as slice%03d.raw 1 60 1");
  std::vector<std::int64_t> numbers;
  for (std::size_t i = 1; i < words.size() && i < 4; ++i)
    if (const auto number = number_in<std::int32_t>(words[i])) numbers.push_back(*number);
  if (numbers.size() != 3 || words.size() > 5 || numbers[2] == 0) fields.fail("data file");
  const auto first = numbers[0], last = numbers[1], step = numbers[2];
  const auto count = (last - first) / step + 1;
  constexpr std::int64_t most = 1 << 17;
  if ((last - first) * step < 0 || count > most) fields.fail("data file");
  require_count(fields, axes, std::size_t(count), words.size() > 4 ? std::optional(words[4]) : std::nullopt);
  Names names;
  for (std::int64_t k = 0; k < count; ++k) names.push_back(name.with(first + k * step));
  return names;
}

/// The files that "data file" names: one, a list, or a pattern as "s%03d.raw 1 60 1"; none when the voxels
/// are in the header's own.
std::vector<std::filesystem::path> data_files_of(const NrrdFields& fields,
                                                 const std::vector<NrrdAxis>& axes) {
  const auto value = fields.value("data file");
  if (value.empty()) return {};
  Names names{value};
  const auto words = words_of(value);
  if (is_pattern(value)) {
    names = names_of_pattern(fields, axes);
  } else if (value.starts_with("LIST")) {
    names = fields.listed();
    const auto piece = trimmed(value.substr(4));
    require_count(fields, axes, names.size(), piece.empty() ? std::nullopt : std::optional(piece));
  }
  std::vector<std::filesystem::path> files;
  for (const auto& name : names) files.push_back(fields.path().parent_path() / name);
  return files;
}

}  // namespace

double NrrdAxis::length() const {
  double square = 0;
  for (const double step : direction) square += step * step;
  return std::sqrt(square);
}

void NrrdHeader::fail(const std::string& what) const {
  throw InputError(fmt::format("{}: {}", path.string(), what),
                   "extract one volume, or write its axes as [component] x y z [time]");
}

NrrdHeader read_nrrd_header(const std::filesystem::path& path) {
  const NrrdFields fields(path);
  NrrdHeader header;
  header.path = path;
  read_sizes(fields, header);
  header.type = type_of(fields);
  read_kinds(fields, header);
  read_spacings(fields, header);
  read_space(fields, header);
  read_directions(fields, header);
  header.encoding = encoding_of(fields);
  header.big_endian = is_big_endian(fields, header);
  read_skips(fields, header);
  header.files = data_files_of(fields, header.axes);
  if (header.files.empty()) {
    header.files = {path};
    header.end = fields.end();
  }
  return header;
}

}  // namespace ringsplat::detail
