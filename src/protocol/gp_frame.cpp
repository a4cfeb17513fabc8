#include "protocol/gp_frame.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace ringsplat {

GpFrame::GpFrame(int gp, const Announcement& announcement, int renderers, Engine& engine)
    : number(announcement.frame),
      plan(engine.plan(announcement)),
      drawing(plan.drawing(renderers)),
      tokens(int(std::count(drawing.begin(), drawing.end(), true))),
      encoder(engine.encoder(gp, announcement)),
      shown(encoder->shown()) {
  // With nothing to show, tokens still visit one step: Renderers wait to learn that no payload comes.
  if (shown.empty()) shown.push_back(0);
  for (const int step : shown)
    if (plan.owners[std::size_t(step)] == gp) steps.push_back(step);
  if (tokens > 0) return;
  // The volume lies beside the picture.
  stats.voxels_outside = encoder->left_out(steps.size()).outside;
  steps.clear();
}

bool GpFrame::owns(int step) const { return std::binary_search(steps.begin(), steps.end(), step); }

std::optional<int> GpFrame::after(int step) const {
  const auto next = std::upper_bound(shown.begin(), shown.end(), step);
  return next == shown.end() ? std::nullopt : std::optional(*next);
}

PreparedSlice* GpFrame::find_slice(int step) {
  const auto found =
      std::find_if(prepared.begin(), prepared.end(), [&](const PreparedSlice& s) { return s.step == step; });
  return found == prepared.end() ? nullptr : &*found;
}

void GpFrame::retire_slices() {
  while (!prepared.empty() && prepared.front().tokens_left == 0) {
    prepared.pop_front();
    ++steps_done;
  }
}

/// Owner of the shown step before this one, or of the first shown step.
int GpFrame::owner_before(int step) const {
  const auto here = std::lower_bound(shown.begin(), shown.end(), step);
  return plan.owners[std::size_t(here == shown.begin() ? shown.front() : *std::prev(here))];
}

std::string GpFrame::waiting_for(const std::string& gp) const {
  if (!prepared.empty()) {
    const PreparedSlice& slice = prepared.front();
    if (!slice.awaiting_accept.empty())
      return fmt::format("{} waits for Renderer {} to accept step {} of frame {}", gp,
                         slice.awaiting_accept.begin()->first, slice.step, number);
    return fmt::format("{} waits for {} token(s) of step {} of frame {} from GP {}", gp, slice.tokens_left,
                       slice.step, number, owner_before(slice.step));
  }
  if (steps_done < steps.size()) return fmt::format("{} has slices of frame {} left to encode", gp, number);
  if (!left_behind.empty())
    return fmt::format("{} waits for Renderer {} to accept a payload of frame {}", gp,
                       left_behind.begin()->first, number);
  return {};
}

}  // namespace ringsplat
