#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "ringsplat/base/error.hpp"
#include "serve/viewer.hpp"

namespace ringsplat::live {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

/// What the driver wants of the simulation. For any thread.
class Steering {
 public:
  void offer(const serve::RunState::Parameter& parameter) {
    const std::lock_guard lock(mutex_);
    offered_.insert_or_assign(parameter.name, parameter);
  }

  /// Throws InputError, for the page.
  void take(const serve::SteerMessage& wanted) {
    using Act = serve::SteerMessage::Act;
    const std::lock_guard lock(mutex_);
    if (wanted.act == Act::set) return set(wanted.parameter, wanted.value);
    paused_ = wanted.act != Act::resume;
    steps_ = wanted.act == Act::step ? steps_ + 1 : 0;
  }

  bool paused() const {
    const std::lock_guard lock(mutex_);
    return paused_;
  }
  /// It must not go on.
  bool holds() const {
    const std::lock_guard lock(mutex_);
    return paused_ && steps_ == 0;
  }
  /// It goes on: one of the steps that were wanted is being taken.
  void go_on() {
    const std::lock_guard lock(mutex_);
    steps_ = std::max(steps_ - 1, 0);
  }
  void let_go() {
    const std::lock_guard lock(mutex_);
    paused_ = false;
  }
  /// The value that is wanted of a parameter, once.
  std::optional<double> wanted(const std::string& parameter) {
    const std::lock_guard lock(mutex_);
    const auto wish = wishes_.extract(parameter);
    return wish ? std::optional(wish.mapped()) : std::nullopt;
  }
  /// A value that is wanted and not yet taken, or `now`.
  double seen(const std::string& parameter, double now) const {
    const std::lock_guard lock(mutex_);
    const auto wish = wishes_.find(parameter);
    return wish == wishes_.end() ? now : wish->second;
  }

 private:
  void set(const std::string& name, double value) {
    const auto found = offered_.find(name);
    if (found == offered_.end()) throw InputError(fmt::format("the simulation offers no {}", name));
    const auto& [low, high] = std::pair(found->second.low, found->second.high);
    if (!(value >= low && value <= high))
      throw InputError(fmt::format("{} must be from {:g} to {:g}", name, low, high));
    wishes_[name] = value;
  }

  mutable std::mutex mutex_;
  bool paused_ = false;
  int steps_ = 0;  ///< that are wanted while it is paused
  std::map<std::string, serve::RunState::Parameter> offered_;
  std::map<std::string, double> wishes_;
};

/// Keeps what pictures take to a part of the simulation's own time.
class Share {
 public:
  explicit Share(double part) : part_(part) {}
  void came_back() { debt_ = std::max(0.0, debt_ - part_ * seconds_since(left_)); }
  bool allows_a_picture() const { return debt_ <= 0; }
  void spent(double seconds) { debt_ += seconds; }
  void leave() { left_ = Clock::now(); }

 private:
  double part_, debt_ = 0;
  Clock::time_point left_ = Clock::now();
};

}  // namespace ringsplat::live
