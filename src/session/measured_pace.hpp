#pragma once
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "record/stats.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "ringsplat/net/layout.hpp"

namespace ringsplat {

/// What frames took Renderers beside what was foreseen: slow cores, and work that the volume's sketch does
/// not show where it lies. Told with the next frames, it evens out their regions.
class MeasuredPace {
 public:
  explicit MeasuredPace(const Layout& layout) : layout_(layout) {}

  /// Completes a frame's division.
  void tell(Division& division) {
    if (division.dealt_to == 0) division.dealt_to = layout_.renderers;
    pace_.resize(dealt_to(division), 1);
    if (std::ranges::any_of(pace_, [](float one) { return std::abs(std::log(one)) > worth_telling; }))
      division.pace = pace_;
  }
  /// From a frame that was told so.
  void learn(const Division& division, const FrameStats& stats) {
    const std::size_t drawing = dealt_to(division);
    if (drawing < 2 || drawing != pace_.size()) return;
    std::vector<double> spent, busy;
    for (std::size_t k = 0; k < drawing; ++k) {
      const std::size_t renderer = k * stats.renderers.size() / drawing;
      const NodeStats& node = stats.renderers[renderer];
      spent.push_back(node.drawing + node.compositing);
      const bool both = layout_.placement == Placement::colocated && renderer < stats.gps.size();
      busy.push_back(both ? stats.gps[renderer].computing : 0);
    }
    const double all = std::accumulate(spent.begin(), spent.end(), 0.0),
                 even = std::accumulate(busy.begin(), busy.end(), all) / double(drawing);
    for (std::size_t k = 0; k < drawing; ++k) {
      const double wanted = std::max(even - busy[k], 0.1 * even);
      if (wanted > 0) pace_[k] *= float(std::sqrt(std::clamp(spent[k] / wanted, 0.5, 2.0)));
    }
    const float mean = std::accumulate(pace_.begin(), pace_.end(), 0.0F) / float(drawing);
    for (float& one : pace_) one = std::clamp(one / mean, 0.125F, 8.0F);
  }

 private:
  static constexpr float worth_telling = 0.05F;
  std::size_t dealt_to(const Division& division) const {
    return std::size_t(std::min(division.dealt_to, layout_.renderers));
  }

  Layout layout_;
  std::vector<float> pace_;  ///< by Renderer that gets regions
};

}  // namespace ringsplat
