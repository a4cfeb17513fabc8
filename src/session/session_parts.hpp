#pragma once
#include <functional>
#include <string>
#include <vector>

#include "ringsplat/session/session.hpp"
#include "session/director.hpp"
#include "volume/value_statistics.hpp"

namespace ringsplat {

/// What a session can do for other rooms that is not for users.
struct SessionParts {
  /// Has the session's next collective call throw this as InputError on all ranks.
  static void note_problem(Session& session, const std::string& problem);
  /// Of the committed volume, until the next commit. Collective; `call` is its name for people.
  static const ValueStatistics& values(Session& session, const char* call = "values");
  /// As Session::render(), with all that is known of each frame.
  static void render(Session& session, const std::vector<FrameSpec>& frames,
                     const std::function<void(FrameResult&&)>& take);
};

}  // namespace ringsplat
