#pragma once
#include <map>

#include "protocol/frame_source.hpp"
#include "session/director.hpp"

namespace ringsplat {

/// Supplies the protocol with a director's frames.
class DirectedFrames final : public FrameSource {
 public:
  DirectedFrames(Director director, const Grid& grid, int renderers);

  std::optional<Bytes> next(std::int64_t frame) override;
  bool may_come() override { return director_.may_come && director_.may_come(); }
  bool unwanted(std::int64_t frame) override;
  void done(FrameStats&& stats) override;
  void pause(std::chrono::nanoseconds most) override;
  /// Keeps the picture of a frame until done().
  void take_picture(std::int64_t frame, Image&& picture) { frames_.at(frame).image = std::move(picture); }

 private:
  struct Announced {
    FrameSpec spec;
    Image image;
  };
  Director director_;
  Grid grid_;
  int renderers_;
  std::map<std::int64_t, Announced> frames_;  ///< announced and not done
};

}  // namespace ringsplat
