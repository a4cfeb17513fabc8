#pragma once
#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/input_file.hpp"

namespace ringsplat::detail {

inline constexpr std::uint64_t file_end = ~std::uint64_t{0};

/// Reads the bytes [begin, end) of a file as text, in order, through a small window. The file must outlive
/// it.
class TextReader {
 public:
  explicit TextReader(const InputFile& file, std::uint64_t begin = 0, std::uint64_t end = file_end)
      : file_(file), offset_(begin), end_(end) {}

  std::uint64_t position() const { return offset_ + at_; }  ///< the byte that is read next
  /// The next character, which advance() passes; nothing at the end.
  std::optional<char> peek() {
    if (at_ == got_ && !refill()) return {};
    return char(window_[at_]);
  }
  void advance() { ++at_; }

  /// The next line without its end, which is "\n", "\r\n" or "\r"; nothing at the end. The rest of a line
  /// that is longer than a MiB is left out.
  std::optional<std::string> line() {
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
  /// The next word between blanks and commas; empty at the end. A word longer than any number is split.
  std::string word() {
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

 private:
  bool refill() {
    offset_ += got_;
    at_ = 0;
    const auto wanted = std::min<std::uint64_t>(window_.size(), end_ - std::min(end_, offset_));
    got_ = file_.read_some(offset_, std::span(window_).first(std::size_t(wanted)));
    return got_ > 0;
  }

  const InputFile& file_;
  std::uint64_t offset_, end_;
  std::vector<std::byte> window_ = std::vector<std::byte>(64 * 1024);
  std::size_t at_ = 0, got_ = 0;
};

}  // namespace ringsplat::detail
