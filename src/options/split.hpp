#pragma once
#include <cstddef>
#include <string_view>
#include <vector>

namespace ringsplat::app {

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

}  // namespace ringsplat::app
