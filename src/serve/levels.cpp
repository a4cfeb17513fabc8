#include "serve/levels.hpp"

#include <algorithm>

namespace ringsplat::serve {
namespace {

constexpr double too_slow = 1.2, quick_enough = 0.7;
constexpr int slow_pictures = 2, quick_pictures = 10;
/// What a level cost so many pictures ago tells nothing any more.
constexpr long memory = 100;
/// How many levels below the best the middle one at rest is: draft.
constexpr int middle_below_best = 2;

}  // namespace

std::vector<Level> make_levels(const Qualities& q, const glm::ivec3& dims) {
  constexpr int least_voxels = 16;  // along an undersampled volume's shortest side
  const int shortest = std::min({dims.x, dims.y, dims.z});
  std::vector<Level> levels;
  if (shortest / 4 >= least_voxels) levels.push_back({"1/4 of the voxels, half size", 4, true, q.draft});
  if (shortest / 2 >= least_voxels) {
    levels.push_back({"1/2 of the voxels, half size", 2, true, q.draft});
    levels.push_back({"1/2 of the voxels", 2, false, q.draft});
  }
  levels.push_back({"draft, half size", 1, true, q.draft});
  levels.push_back({"draft", 1, false, q.draft});
  levels.push_back({"normal", 1, false, q.normal});
  levels.push_back({"best", 1, false, q.best});
  return levels;
}

FrameSpec at_level(FrameSpec spec, const Level& level) {
  spec.how = level.sheets;
  spec.shown.reduction.factor = level.undersample;
  if (level.half_size) {
    spec.shown.width = (spec.shown.width + 1) / 2;
    spec.shown.height = (spec.shown.height + 1) / 2;
  }
  return spec;
}

LevelController::LevelController(int levels, double target_seconds)
    : target_(target_seconds), costs_(std::size_t(levels)) {}

std::optional<double> LevelController::recent(int level) const {
  const auto& cost = costs_[std::size_t(level)];
  return cost && pictures_ - cost->at <= memory ? std::optional(cost->seconds) : std::nullopt;
}

bool LevelController::may_fit(int level) const { return recent(level).value_or(0) <= target_; }

void LevelController::moved(double seconds) {
  ++pictures_;
  costs_[std::size_t(level_)] = {seconds, pictures_};
  slow_ = seconds > too_slow * target_ ? slow_ + 1 : 0;
  quick_ = seconds < quick_enough * target_ ? quick_ + 1 : 0;
  if (slow_ >= slow_pictures && level_ > 0) {
    --level_;
    slow_ = quick_ = 0;
  } else if (quick_ >= quick_pictures) {
    quick_ = 0;
    if (level_ + 1 < int(costs_.size()) && may_fit(level_ + 1)) ++level_;
  }
}

void LevelController::rested(int level, double seconds) {
  ++pictures_;
  costs_[std::size_t(level)] = {seconds, pictures_};
}

void LevelController::begin_motion() {
  slow_ = quick_ = 0;
  for (int finer = int(costs_.size()) - 1; finer > level_; --finer)
    if (const auto seconds = recent(finer); seconds && *seconds <= quick_enough * target_) {
      level_ = finer;
      return;
    }
}

void LevelController::forget() {
  for (auto& cost : costs_) cost.reset();
  slow_ = quick_ = 0;
}

std::optional<int> next_level_at_rest(const LevelController& controller, int levels, double target_seconds,
                                      std::optional<int> shown) {
  constexpr double soon = 1.5, long_wait = 4;
  const int best = levels - 1, middle = std::max(0, best - middle_below_best);
  if (shown == best) return std::nullopt;
  const std::optional<double> cost = controller.recent(best);
  if (!shown) return cost && *cost <= soon * target_seconds ? best : controller.level();
  const bool worth_waiting = cost && *cost <= long_wait * target_seconds;
  return *shown < middle && !worth_waiting ? middle : best;
}

}  // namespace ringsplat::serve
