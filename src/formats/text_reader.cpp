#include "formats/text_reader.hpp"

#include <algorithm>
#include <cctype>
#include <span>

namespace ringsplat::detail {

bool TextReader::refill() {
  offset_ += got_;
  at_ = 0;
  const auto wanted = std::min<std::uint64_t>(window_.size(), end_ - std::min(end_, offset_));
  got_ = file_.read_some(offset_, std::span(window_).first(std::size_t(wanted)));
  return got_ > 0;
}

std::optional<std::string> TextReader::line() {
  constexpr std::size_t longest = 1 << 20;
  if (!peek()) return {};
  std::string line;
  for (auto c = peek(); c; c = peek()) {
    advance();
    if (*c == '\n') break;
    if (*c == '\r') {
      if (peek() == '\n') advance();
      break;
    }
    if (line.size() < longest) line += *c;
  }
  return line;
}

std::string TextReader::word() {
  constexpr std::size_t longest = 400;
  std::string word;
  for (auto c = peek(); c && word.size() < longest; c = peek()) {
    const bool between = *c == ',' || std::isspace(static_cast<unsigned char>(*c)) != 0;
    if (between && !word.empty()) break;
    advance();
    if (!between) word += *c;
  }
  return word;
}

}  // namespace ringsplat::detail
