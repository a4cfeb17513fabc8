#pragma once
#include <algorithm>
#include <functional>

#include "base/clock.hpp"

namespace ringsplat {

/// Which part of a deal's time has passed. Slices are read and dealt in turns, each at a pace of its own, so
/// neither count alone would tell how long the rest takes. Until the first slice is dealt, dealing is taken
/// to be as fast as reading.
class LoadPace {
 public:
  LoadPace(int slices, const std::function<void(double part)>& told) : slices_(slices), told_(told) {}

  /// Starts the clock: slices begin to be read.
  void begin() {
    last_ = now_seconds();
    if (told_) told_(0);
  }
  /// So many slices have been read; the time since the last call went into it.
  void read(double slices) { note(read_, slices); }
  void dealt(double slices) { note(dealt_, slices); }

 private:
  struct Work {
    double slices = 0, seconds = 0;
    double each() const { return slices > 0 ? seconds / slices : 0; }
  };
  void note(Work& work, double slices) {
    const double now = now_seconds();
    work.seconds += now - last_;
    work.slices = slices;
    last_ = now;
    if (!told_) return;
    const double whole = slices_ * (read_.each() + (dealt_.slices > 0 ? dealt_.each() : read_.each()));
    if (whole <= 0) return;
    part_ = std::max(part_, std::min(1.0, (read_.seconds + dealt_.seconds) / whole));
    told_(part_);
  }

  int slices_;
  const std::function<void(double)>& told_;
  Work read_, dealt_;
  double last_ = now_seconds(), part_ = 0;
};

}  // namespace ringsplat
