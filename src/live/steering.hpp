#pragma once
#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "ringsplat/base/error.hpp"
#include "serve/viewer.hpp"

namespace ringsplat::live {

/// What the driver wants of the simulation. For any thread.
class Steering {
 public:
  /// Parameters are numbered in this order.
  void offer(const serve::RunState::Parameter& parameter) {
    const std::lock_guard lock(mutex_);
    offered_.push_back({parameter, {}});
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
  /// What parameters are in the program now.
  void see(const std::vector<double>& values) {
    const std::lock_guard lock(mutex_);
    for (std::size_t k = 0; k < values.size(); ++k) offered_[k].parameter.value = values[k];
  }
  /// As they were seen last, or as they are wanted.
  std::vector<serve::RunState::Parameter> parameters() const {
    const std::lock_guard lock(mutex_);
    std::vector<serve::RunState::Parameter> all;
    for (const auto& [parameter, wish] : offered_) {
      all.push_back(parameter);
      all.back().value = wish.value_or(parameter.value);
    }
    return all;
  }
  /// Has them so: their values; nothing is wanted any more.
  std::vector<double> take_values() {
    const std::lock_guard lock(mutex_);
    std::vector<double> values;
    for (auto& [parameter, wish] : offered_)
      values.push_back(parameter.value = std::exchange(wish, {}).value_or(parameter.value));
    return values;
  }

 private:
  struct Offered {
    serve::RunState::Parameter parameter;
    std::optional<double> wish;
  };

  void set(const std::string& name, double value) {
    const auto found = std::find_if(offered_.begin(), offered_.end(),
                                    [&](const Offered& one) { return one.parameter.name == name; });
    if (found == offered_.end()) throw InputError(fmt::format("the simulation offers no {}", name));
    const serve::RunState::Parameter& its = found->parameter;
    if (!(value >= its.low && value <= its.high))
      throw InputError(fmt::format("{} must be from {:g} to {:g}", name, its.low, its.high));
    found->wish = value;
  }

  mutable std::mutex mutex_;
  bool paused_ = false;
  int steps_ = 0;  ///< that are wanted while it is paused
  std::vector<Offered> offered_;
};

/// Keeps what pictures take to a part of the simulation's own time.
class Share {
 public:
  explicit Share(double part) : part_(part) {}
  void came_back() { debt_ = std::max(0.0, debt_ - part_ * (now_seconds() - left_)); }
  bool allows_a_picture() const { return debt_ <= 0; }
  void spent(double seconds) { debt_ += seconds; }
  void leave() { left_ = now_seconds(); }

 private:
  double part_, debt_ = 0, left_ = now_seconds();
};

}  // namespace ringsplat::live
