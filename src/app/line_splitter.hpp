#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

namespace ringsplat::app {

/// Cuts text that comes in pieces into lines. Of a line that is too long only its beginning is kept.
class LineSplitter {
 public:
  static constexpr std::size_t most_bytes = 4096;  ///< of a line without its line feed

  struct Line {
    std::string text;    ///< of a line that is too long the first most_bytes
    std::size_t number;  ///< from 1
    bool too_long;
  };
  using Take = std::function<void(const Line&)>;

  /// Calls `take` for each line that ends in this piece, and for one that becomes too long as soon as it
  /// does.
  void add(std::string_view piece, const Take& take);
  /// The last line, when no line feed ends it.
  void end(const Take& take);

 private:
  void hand_over(const Take& take, bool too_long);

  std::string text_;
  std::size_t number_ = 1;
  bool skipping_ = false;  ///< the rest of a line that was too long
};

}  // namespace ringsplat::app
