#pragma once
#include <optional>
#include <string>

namespace ringsplat::app {

/// What --frames says: from `first` to before `end`, every `step`-th.
struct FrameRange {
  std::optional<int> first, end;  ///< from 0; missing: the first there is, and to the last
  int step = 1;                   ///< at least 1
  std::string text;               ///< as it was given
};

/// "all", "A:B", "A:B:STEP"; each of A, B and STEP may be missing. Throws InputError.
FrameRange parse_frames(const std::string& text, const std::string& option);

}  // namespace ringsplat::app
