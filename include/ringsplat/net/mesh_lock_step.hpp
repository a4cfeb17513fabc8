#pragma once
#include <cstdint>
#include <functional>
#include <map>

#include "ringsplat/net/mesh.hpp"

namespace ringsplat {

/// Moves all tokens one GP per step, whatever the delays between them: the clock that the proof in mesh.hpp
/// assumes, for runs in one process. A Renderer's k-th place in the train is that in which the front
/// slice's owner first uses its token. Its payload of traversal step s leaves in step k + s after the
/// frame's start, its token in the step after.
class LockStep {
 public:
  /// Called with every link in use and the step of the clock.
  using Observer = std::function<void(std::int64_t step, const Link& link, const Header& header)>;

  explicit LockStep(Observer observer = {}) : observer_(std::move(observer)) {}

  /// True when a message may leave its node now.
  bool may_leave(const Header& header);
  void record(const Link& link, const Header& header) const;
  /// One step of the clock; for when everything that may leave has arrived.
  void advance() { ++now_; }
  /// Messages that are kept at their nodes until their step.
  int kept = 0;

 private:
  Observer observer_;
  std::int64_t now_ = 0;
  std::int64_t frame_ = -1, frame_start_ = 0;  ///< of the frame under way; there is only one at a time
  std::map<int, int> places_;                  ///< in the train, by Renderer
};

}  // namespace ringsplat
