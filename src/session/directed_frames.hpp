#pragma once
#include <map>
#include <utility>

#include "frame/frame_geometry.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "protocol/frame_source.hpp"
#include "session/director.hpp"

namespace ringsplat {

/// Supplies the protocol with a director's frames.
class DirectedFrames final : public FrameSource {
 public:
  DirectedFrames(Director director, const Grid& grid, int renderers)
      : director_(std::move(director)), grid_(grid), renderers_(renderers) {}

  std::optional<Bytes> next(std::int64_t frame) override {
    auto spec = director_.next_frame();
    if (!spec) return std::nullopt;
    spec->frame = frame;
    if (spec->division.dealt_to == 0) spec->division.dealt_to = renderers_;
    Bytes body = encode(*spec);
    frames_[frame].spec = std::move(*spec);
    return body;
  }
  bool may_come() override { return director_.may_come && director_.may_come(); }
  bool unwanted(std::int64_t frame) override {
    return director_.unwanted && director_.unwanted(frames_.at(frame).spec);
  }
  void done(FrameStats&& stats) override {
    auto [spec, image] = std::move(frames_.extract(stats.frame).mapped());
    if (stats.dropped) return;
    const Axis axis = traversed_axis(spec, grid_);
    director_.frame_done({std::move(spec), std::move(image), std::move(stats), axis});
  }
  void pause(std::chrono::nanoseconds most) override {
    if (director_.pause)
      director_.pause(most);
    else
      FrameSource::pause(most);
  }
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
