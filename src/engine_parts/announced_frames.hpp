#pragma once
#include <cstdint>
#include <deque>
#include <memory>

#include "protocol/engine.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat {

/// What rank 0 announced. Throws RunError when the bytes are no description of that frame.
FrameSpec announced_spec(const Announcement& announcement);

/// The frames in flight of a rank, which its nodes share. A Frame has a `number`.
template <class Frame>
class AnnouncedFrames {
 public:
  using Shared = std::shared_ptr<const Frame>;

  /// The announced frame; `make(spec)` makes it when it is new. Throws RunError when it cannot be: another
  /// rank announced it, so no input of this one is to blame.
  template <class Make>
  Shared get(const Announcement& a, Make&& make) {
    for (const auto& known : frames_)
      if (known->number == a.frame) return known;
    constexpr std::size_t most_remembered = 4;
    if (frames_.size() == most_remembered) frames_.pop_front();
    try {
      const FrameSpec spec = announced_spec(a);
      check(spec);
      return frames_.emplace_back(make(spec));
    } catch (const InputError& e) {
      throw RunError(std::string("rank 0 told of a frame that cannot be: ") + e.what());
    }
  }

 private:
  std::deque<Shared> frames_;
};

}  // namespace ringsplat
