#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace ringsplat::app {

/// Cuts text that comes in pieces into lines. Keeps only the beginning of a line that is too long.
class LineSplitter {
 public:
  static constexpr std::size_t most_bytes = 4096;  ///< longest line, without its line feed

  struct Line {
    std::string text;    ///< the first most_bytes if the line is too long
    std::size_t number;  ///< from 1
    bool too_long;
  };
  using Take = std::function<void(const Line&)>;

  /// Calls `take` for each line that ends in this piece, and for a line as soon as it becomes too long.
  void add(std::string_view piece, const Take& take);
  /// Calls `take` for a last line without a line feed.
  void end(const Take& take);

 private:
  void hand_over(const Take& take, bool too_long);

  std::string text_;
  std::size_t number_ = 1;
  bool skipping_ = false;  ///< the rest of a line that was too long
};

}  // namespace ringsplat::app
