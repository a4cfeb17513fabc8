#include "options/line_splitter.hpp"

namespace ringsplat::app {

void LineSplitter::add(std::string_view piece, const Take& take) {
  while (!piece.empty()) {
    const std::size_t feed = piece.find('\n');
    const std::string_view part = piece.substr(0, feed);
    if (!skipping_) {
      text_.append(part.substr(0, most_bytes + 1 - text_.size()));
      if (text_.size() > most_bytes) {
        text_.pop_back();
        hand_over(take, true);
        skipping_ = true;
      }
    }
    if (feed == std::string_view::npos) return;
    if (!skipping_) hand_over(take, false);
    skipping_ = false;
    ++number_;
    piece.remove_prefix(feed + 1);
  }
}

void LineSplitter::end(const Take& take) {
  if (!text_.empty()) hand_over(take, false);
}

void LineSplitter::hand_over(const Take& take, bool too_long) {
  take({text_, number_, too_long});
  text_.clear();
}

}  // namespace ringsplat::app
