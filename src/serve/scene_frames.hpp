#pragma once
#include <vector>

#include "classify/adjust.hpp"
#include "serve/levels.hpp"
#include "serve/viewer.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::serve {

/// Gives `shown` a channel's function, over its window and in its colour.
inline void look_as(const ChannelState& look, const ShownChannel& channel, Shown& shown) {
  const Shown& own = channel.own.at(shown.mode);
  shown.transfer_function = own.transfer_function;
  shown.interpolation = own.interpolation;
  shown.isovalue = look.window.x;
  if (look.window != channel.window(shown.mode))
    stretch(shown.transfer_function, {look.window.x, look.window.y});
  for (auto& point : shown.transfer_function.colours) point.srgb *= look.colour;
}

/// What shows a scene at a level: a frame, or one of each visible channel. Where none is visible the first is
/// drawn, clear. Throws InputError when a channel's look makes no frame.
inline std::vector<VolumeFrame> frames_of(const SceneState& scene, const Level& level,
                                          const ViewerOptions& options) {
  FrameSpec frame = options.frame;
  frame.shown = scene.shown;
  frame = at_level(std::move(frame), level);
  std::vector<VolumeFrame> frames;
  for (std::size_t k = 0; k < scene.channels.size(); ++k) {
    if (!scene.channels[k].visible) continue;
    frames.push_back({k, frame});
    look_as(scene.channels[k], options.channels[k], frames.back().spec.shown);
    check(frames.back().spec);
  }
  if (!frames.empty()) return frames;
  if (!scene.channels.empty())
    for (auto& point : frame.shown.transfer_function.opacities) point.opacity = 0;
  return {{0, frame}};
}

}  // namespace ringsplat::serve
