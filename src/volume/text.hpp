#pragma once
#include <algorithm>
#include <cctype>
#include <string>

namespace ringsplat::detail {

/// "a, b, c". (fmt::join makes GCC 12 warn falsely of an overflow inside fmt.)
template <class Range>
std::string comma_list(const Range& names) {
  std::string list;
  for (const auto& name : names) {
    if (!list.empty()) list += ", ";
    list += name;
  }
  return list;
}

inline std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

/// Without line ends, doubled blanks and blanks at the ends: libraries describe errors in several lines.
inline std::string one_line(const std::string& text) {
  std::string line;
  for (const char c : text) {
    const bool space = std::isspace(static_cast<unsigned char>(c)) != 0;
    if (!space)
      line += c;
    else if (!line.empty() && line.back() != ' ')
      line += ' ';
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

}  // namespace ringsplat::detail
