#include "formats/nrrd/fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include "base/text.hpp"
#include "formats/text_reader.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::uint64_t longest_header = 64 << 20;  // bytes; a header has a few hundred

/// In small letters without blanks.
constexpr std::string_view known_fields[] = {"content",
                                             "number",
                                             "type",
                                             "blocksize",
                                             "dimension",
                                             "space",
                                             "spacedimension",
                                             "sizes",
                                             "spacings",
                                             "thicknesses",
                                             "axismins",
                                             "axismaxs",
                                             "centers",
                                             "spacedirections",
                                             "centerings",
                                             "kinds",
                                             "labels",
                                             "units",
                                             "min",
                                             "max",
                                             "oldmin",
                                             "oldmax",
                                             "endian",
                                             "encoding",
                                             "lineskip",
                                             "byteskip",
                                             "sampleunits",
                                             "spaceunits",
                                             "spaceorigin",
                                             "measurementframe",
                                             "datafile"};

std::string spelled(const std::string& field) {
  std::string name = lower_case(trimmed(field));
  std::erase(name, ' ');
  return name == "centers" ? "centerings" : name;
}

bool is_known(const std::string& field) {
  return std::find(std::begin(known_fields), std::end(known_fields), field) != std::end(known_fields);
}

}  // namespace

void fail_nrrd(const std::filesystem::path& path, const std::string& what) {
  throw InputError(fmt::format("{} is not a readable NRRD file: {}", path.string(), what),
                   "see teem.sourceforge.net/nrrd for the format");
}

NrrdFields::NrrdFields(const std::filesystem::path& path) : path_(path) {
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

void NrrdFields::take(const std::string& line) {
  if (line.starts_with('#')) return;
  const auto colon = line.find(':');
  const auto field = spelled(line.substr(0, colon));
  const bool is_pair = line.find(":=") != std::string::npos;  // key and value, which mean nothing here
  if (colon == std::string::npos || line.compare(colon, 2, ":=") == 0 || !is_known(field)) {
    if (is_pair) return;
    fail_nrrd(path_, fmt::format("'{}' is no line of a header", excerpt(line)));
  }
  if (!values_.emplace(field, trimmed(line.substr(colon + 1))).second)
    fail_nrrd(path_, fmt::format("'{}' is given twice", excerpt(line.substr(0, colon))));
}

std::string NrrdFields::value(const std::string& field) const {
  const auto found = values_.find(spelled(field));
  return found == values_.end() ? std::string() : found->second;
}

std::string NrrdFields::required(const std::string& field) const {
  const auto text = value(field);
  if (text.empty()) fail_nrrd(path_, fmt::format("'{}' is missing", field));
  return text;
}

void NrrdFields::fail(const std::string& field) const {
  fail_nrrd(path_, fmt::format("its {} is '{}'", field, excerpt(value(field))));
}

std::vector<std::string> NrrdFields::words(const std::string& field) const { return words_of(value(field)); }

std::vector<std::string> NrrdFields::words_of_axes(const std::string& field, std::size_t axes) const {
  const auto list = words(field);
  if (!list.empty() && list.size() != axes)
    fail_nrrd(path_, fmt::format("it has {} {}, but its dimension is {}", list.size(), field, axes));
  return list;
}

std::vector<double> NrrdFields::numbers_of_axes(const std::string& field, std::size_t axes) const {
  std::vector<double> numbers;
  for (const auto& word : words_of_axes(field, axes)) {
    const auto number = number_in<double>(lower_case(word));
    if (!number || std::isinf(*number)) fail(field);
    numbers.push_back(*number);
  }
  return numbers;
}

std::vector<double> NrrdFields::vector_in(const std::string& text, const std::string& field,
                                          int axes_of_space) const {
  std::vector<double> vector;
  for (std::size_t at = 0; at <= text.size();) {
    const auto comma = std::min(text.find(',', at), text.size());
    const auto number = number_in<double>(lower_case(trimmed(text.substr(at, comma - at))));
    if (!number || std::isinf(*number)) fail(field);
    vector.push_back(*number);
    at = comma + 1;
  }
  if (int(vector.size()) != axes_of_space) fail(field);
  const auto missing = std::count_if(vector.begin(), vector.end(), [](double v) { return std::isnan(v); });
  if (missing == axes_of_space) return {};
  if (missing > 0) fail(field);
  return vector;
}

std::vector<std::vector<double>> NrrdFields::vectors(const std::string& field, int axes_of_space) const {
  const std::string text = value(field), blanks = " \t";
  std::vector<std::vector<double>> list;
  for (auto at = text.find_first_not_of(blanks); at < text.size(); at = text.find_first_not_of(blanks, at)) {
    if (axes_of_space == 0) fail_nrrd(path_, fmt::format("its {} has no space, or space dimension", field));
    if (text[at] != '(') {
      const auto end = std::min(text.find_first_of(blanks, at), text.size());
      if (text.substr(at, end - at) != "none") fail(field);
      list.emplace_back();
      at = end;
      continue;
    }
    const auto end = text.find(')', at);
    if (end == std::string::npos) fail(field);
    list.push_back(vector_in(text.substr(at + 1, end - at - 1), field, axes_of_space));
    at = end + 1;
  }
  return list;
}

std::int64_t NrrdFields::integer(const std::string& field, std::int64_t otherwise) const {
  const auto text = value(field);
  if (text.empty()) return otherwise;
  const auto number = number_in<std::int64_t>(text);
  if (!number) fail(field);
  return *number;
}

}  // namespace ringsplat::detail
