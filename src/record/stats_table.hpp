#pragma once
#include <string>
#include <vector>

#include "record/stats.hpp"

namespace ringsplat {

/// What each rank did in all frames, as a table for people.
class StatsTable {
 public:
  explicit StatsTable(const Layout& layout);
  void add(const FrameStats& frame);
  /// `items`: what payloads hold, "splats" or "blocks".
  std::string text(const char* items) const;

 private:
  Layout layout_;
  int frames_ = 0;
  std::vector<NodeStats> gps_, renderers_;
};

}  // namespace ringsplat
