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
    if (pace_.size() != dealt_to(division)) pace_.assign(dealt_to(division), 1), told_.clear();
    // What is told stays until it is clearly wrong: blocks that Renderers keep are of use only to regions
    // that stay where they are.
    const auto told = [&](std::size_t k) { return told_.empty() ? 1 : told_[k]; };
    for (std::size_t k = 0; k < pace_.size(); ++k)
      if (std::abs(std::log(pace_[k] / told(k))) > worth_telling) {
        told_ = pace_;
        break;
      }
    division.pace = told_;
  }
  /// From a frame of this division. Frames may be on their way that were told something else, so what it was
  /// told counts, not what is known now.
  void learn(const Division& division, const FrameStats& stats) {
    const std::size_t drawing = dealt_to(division);
    if (drawing < 2 || drawing != pace_.size()) return;
    const bool colocated = layout_.placement == Placement::colocated;
    std::vector<double> spent, busy;
    for (std::size_t k = 0; k < drawing; ++k) {
      const std::size_t renderer = k * stats.renderers.size() / drawing;
      const NodeStats& node = stats.renderers[renderer];
      spent.push_back(node.drawing + node.compositing);
      busy.push_back(colocated && renderer < stats.gps.size() ? stats.gps[renderer].computing : 0);
    }
    const double all = std::accumulate(spent.begin(), spent.end(), 0.0),
                 even = std::accumulate(busy.begin(), busy.end(), all) / double(drawing);
    if (!(even > least_seconds)) return;
    for (std::size_t k = 0; k < drawing; ++k) {
      double ratio =
          std::clamp(spent[k] / std::max(even - busy[k], 0.1 * even), 1 / most_a_frame, most_a_frame);
      // Rank 0 puts the picture together as well, which is none of its nodes' time.
      if (colocated && k == 0) ratio = std::max(ratio, 1.0);
      const double told = division.pace.size() == drawing ? division.pace[k] : 1;
      // Nothing is learnt of those that had nothing to draw.
      pace_[k] = float(std::pow(pace_[k], 1 - weight) * std::pow(spent[k] > 0 ? told * ratio : 1, weight));
    }
    const double mean = std::accumulate(pace_.begin(), pace_.end(), 0.0) / double(drawing);
    for (float& one : pace_) one = float(std::clamp(one / mean, 1 / most, most));
  }

 private:
  /// A single frame tells little: something else may have had the core. What is told is off by at most a
  /// fifth, as a logarithm.
  static constexpr double weight = 0.3, most_a_frame = 1.3, worth_telling = 0.2;
  static constexpr double most = 4, least_seconds = 1e-3;
  std::size_t dealt_to(const Division& division) const {
    return std::size_t(std::min(division.dealt_to, layout_.renderers));
  }

  Layout layout_;
  // By Renderer that gets regions.
  std::vector<float> pace_;
  std::vector<float> told_;  ///< with the last frames; empty: nothing yet
};

}  // namespace ringsplat
