#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "classify/adjust.hpp"
#include "serve/levels.hpp"
#include "serve/viewer.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::serve {

/// What shows a scene at a level: a frame, or one of each visible channel, with its function over its window
/// and in its colour. Where none is visible the first is drawn, clear. Throws InputError when a channel's
/// look makes no frame.
inline std::vector<VolumeFrame> frames_of(const SceneState& scene, const Level& level,
                                          const ViewerOptions& options) {
  FrameSpec frame = options.frame;
  frame.shown = scene.shown;
  frame = at_level(std::move(frame), level);
  std::vector<VolumeFrame> frames;
  for (std::size_t k = 0; k < scene.channels.size(); ++k) {
    const auto& [visible, colour, window] = scene.channels[k];
    if (!visible) continue;
    frames.push_back({k, frame});
    Shown& shown = frames.back().spec.shown;
    const Shown& own = options.channels[k].own.at(shown.mode);
    shown.transfer_function = own.transfer_function;
    shown.interpolation = own.interpolation;
    shown.isovalue = window.x;
    if (window != options.channels[k].window(shown.mode))
      stretch(shown.transfer_function, {window.x, window.y});
    for (auto& point : shown.transfer_function.colours) point.srgb *= colour;
    check(frames.back().spec);
  }
  if (!frames.empty()) return frames;
  if (!scene.channels.empty())
    for (auto& point : frame.shown.transfer_function.opacities) point.opacity = 0;
  return {{0, frame}};
}

/// The driver's views: which is drawn next, and how finely. Not for several threads at once.
class Views {
 public:
  using Clock = std::chrono::steady_clock;

  struct View {
    ViewMessage message;
    std::uint64_t scene = 0;   ///< the same for views that show the same in the same size
    Clock::time_point came;    ///< its own
    std::optional<int> shown;  ///< finest level
  };
  /// A view that can be drawn.
  struct Wish {
    View view;
    bool rests = false;
    std::optional<int> level;  ///< none: it has been shown as well as can be for now
  };

  /// `options` must outlive this.
  explicit Views(const ViewerOptions& options)
      : options_(options),
        levels_(make_levels(options.volume.grid.dims)),
        controller_(options.target_seconds),
        held_{{0}, options.volume.ranges} {}

  const std::vector<Level>& levels() const { return levels_; }
  /// True when the ranks hold all volumes that the scene shows.
  bool can_draw(const SceneState& scene) const {
    return std::ranges::all_of(scene.volumes(), [&](int volume) { return held_.hold(volume); });
  }
  /// The scene of the view that came last.
  const std::optional<SceneState>& last() const { return last_; }
  const HeldVolumes& held() const { return held_; }
  /// Of the view that is drawn now; of the volume that is compared below.
  std::vector<VolumeFrame> frames(int level) const {
    SceneState scene = current_->message.scene;
    if (held_.coarse) scene.shown.reduction.prefilter = held_.coarse->prefilter;
    const auto parts = frames_of(scene, levels_[std::size_t(level)], options_);
    auto frames = held_.frames_of(scene.frame, parts);
    if (!scene.compared) return frames;
    const auto others = held_.frames_of(*scene.compared, parts);
    frames.insert(frames.end(), others.begin(), others.end());
    frames[parts.size()].joins = Joins::below;
    return frames;
  }

  /// The newest view takes the place of one that has not been begun.
  void put(ViewMessage&& message) {
    if (last_ != message.scene) ++scenes_;
    last_ = message.scene;
    newest_ = View{std::move(message), scenes_, Clock::now(), {}};
  }
  void loaded(const HeldVolumes& held) {
    held_ = held;
    not_yet_seen_ = true;
    if (current_) expect();
  }
  void not_loaded(int volume) {
    for (std::optional<View>* const view : {&newest_, &current_})
      if (*view && (*view)->message.scene.shows(volume)) view->reset();
  }
  /// What was drawn is out of date. `changes`: it will soon be so again.
  void renewed(const ValueRange& range, bool changes) {
    held_.ranges = {range};
    changes_ = changes;
    if (current_) current_->shown.reset();
  }

  std::optional<Wish> next() {
    take_newest();
    if (!current_) return std::nullopt;
    Wish wish{*current_,
              !changes_ && (!current_->message.moving || Clock::now() - current_->came >= rest_begins),
              std::nullopt};
    if (wish.rests)
      wish.level = controller_.level_at_rest(current_->shown);
    else if (!current_->shown)
      wish.level = controller_.level();
    return wish;
  }
  void begun() { not_yet_seen_ = false; }
  /// True when a view that looks otherwise than this one waits.
  bool has_newer(const View& view) const { return newest_ && newest_->scene != view.scene; }
  /// True when nothing finer will come of it. What is drawn at best while the view moves is sent with less
  /// quality, and once more when it rests.
  bool drawn(const Wish& wish) {
    const int best = controller_.levels() - 1;
    const bool done = wish.rests && wish.level == best;
    if (current_ && current_->scene == wish.view.scene)
      current_->shown = done ? best : std::min(*wish.level, best - 1);
    return done && !held_.coarse;
  }
  void took(int level, double seconds) { controller_.took(level, seconds); }

 private:
  static constexpr std::chrono::milliseconds rest_begins{150};

  /// While a series is gone through quickly only the newest view's volume is loaded, but one picture is drawn
  /// of each that was.
  void take_newest() {
    if (!newest_) return;
    const bool loaded_for_current =
        not_yet_seen_ && current_ && !current_->shown && can_draw(current_->message.scene);
    if (loaded_for_current && !can_draw(newest_->message.scene)) return;
    View view = *std::exchange(newest_, std::nullopt);
    if (current_ && current_->scene == view.scene) view.shown = current_->shown;
    current_ = std::move(view);
    expect();
  }

  /// Tells the controller what the current view costs at those levels that the ranks can draw.
  void expect() {
    std::vector<double> costs;
    for (std::size_t k = 0; k < levels_.size() && !(held_.coarse && levels_[k].undersample == 1); ++k) {
      const auto parts = frames(int(k));
      // To reduce a volume for a single picture takes longer than to draw it.
      const double one = changes_ && levels_[k].undersample > 1
                             ? std::numeric_limits<double>::infinity()
                             : rough_seconds(parts.front().spec, options_.volume.grid.dims);
      costs.push_back(double(parts.size()) * one);
    }
    controller_.expect(std::move(costs));
  }

  const ViewerOptions& options_;
  const std::vector<Level> levels_;
  LevelController controller_;
  std::optional<View> newest_;  ///< not yet taken
  std::optional<View> current_;
  std::optional<SceneState> last_;
  std::uint64_t scenes_ = 0;
  HeldVolumes held_;
  bool changes_ = false;       ///< the volume does, all the time
  bool not_yet_seen_ = false;  ///< no frame was drawn of the volume since it was loaded
};

}  // namespace ringsplat::serve
