#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <functional>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/printable.hpp"

namespace ringsplat::detail {

/// "a, b, c": of each element the part that is named. (fmt::join makes GCC 12 warn falsely of an overflow
/// inside fmt.)
template <class Range, class Part = std::identity>
std::string joined(const Range& elements, std::string_view between = ", ", const Part& part = {}) {
  std::string list;
  for (const auto& element : elements)
    list += fmt::format("{}{}", list.empty() ? "" : between, std::invoke(part, element));
  return list;
}

/// Of each element the part that is named, or what a function makes of it.
template <class Range, class Part>
auto mapped(Range&& elements, const Part& part) {
  std::vector<std::decay_t<decltype(std::invoke(part, *std::begin(elements)))>> list;
  for (auto&& element : elements) list.push_back(std::invoke(part, element));
  return list;
}

/// What the list has for a key; nothing where it has none.
template <class Key, class T, std::size_t count>
std::optional<T> found(const std::pair<Key, T> (&list)[count], const auto& key) {
  for (const auto& [known, value] : list)
    if (known == key) return value;
  return {};
}

/// "256 x 256 x 128", of a vector.
inline std::string product_of(const auto& v) { return fmt::format("{} x {} x {}", v.x, v.y, v.z); }

inline std::string lower_case(std::string text) {
  for (char& c : text) c = char(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// The words between blanks.
inline std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  return {std::istream_iterator<std::string>(in), {}};
}

/// The parts between separators, each of which is one character; at least one part, which may be empty.
inline std::vector<std::string_view> split(std::string_view text, std::string_view separators) {
  std::vector<std::string_view> parts;
  for (std::size_t at = 0;;) {
    const auto end = text.find_first_of(separators, at);
    parts.push_back(text.substr(at, end - at));
    if (end == std::string_view::npos) return parts;
    at = end + 1;
  }
}

/// The text without line ends, doubled blanks and blanks at the ends. Libraries describe errors in several
/// lines.
inline std::string one_line(const std::string& text) { return joined(words_of(text), " "); }

/// The text without blanks at the ends.
inline std::string trimmed(std::string_view text) {
  constexpr const char* blanks = " \t\n\v\f\r";
  const std::size_t begin = std::min(text.find_first_not_of(blanks), text.size());
  return std::string(text.substr(begin, text.find_last_not_of(blanks) + 1 - begin));
}

/// Parses the whole text as a number; nothing when it is none, has more behind it or does not fit into T.
template <class T>
std::optional<T> number_in(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  T number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return {};
  return number;
}

/// True when `a` comes before `b` as people count: slice2 before slice10, as runs of digits are compared as
/// numbers; those with a zero in front come first.
inline bool naturally_before(const std::string& a, const std::string& b) {
  return strverscmp(a.c_str(), b.c_str()) < 0;
}

}  // namespace ringsplat::detail
