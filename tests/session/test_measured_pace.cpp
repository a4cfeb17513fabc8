#include <algorithm>

#include "session/measured_pace.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

/// A frame in which each Renderer draws for its part of the work, and ranks 0 and 1 encode as well.
FrameStats frame_of(const std::vector<double>& drawing, bool colocated) {
  FrameStats stats;
  for (const double seconds : drawing) {
    stats.renderers.emplace_back().drawing = 0.9 * seconds;
    stats.renderers.back().compositing = 0.1 * seconds;
  }
  stats.gps.resize(2);
  if (colocated) stats.gps[0].computing = 0.2;
  return stats;
}

/// What each takes once what was measured is told, when Renderer k takes slowness[k] seconds for what the
/// others do in one, and work goes to each by its pace.
std::vector<double> learnt(const std::vector<double>& slowness, bool colocated) {
  Layout layout;
  layout.gps = 2;
  layout.renderers = int(slowness.size());
  if (colocated) layout.placement = Placement::colocated;
  MeasuredPace pace(layout);
  std::vector<double> spent;
  for (int frame = 0; frame < 12; ++frame) {
    Division division;
    pace.tell(division);
    std::vector<double> part(slowness.size(), 1.0);
    if (!division.pace.empty())
      for (std::size_t k = 0; k < part.size(); ++k) part[k] = 1 / division.pace[k];
    double all = 0;
    for (const double one : part) all += one;
    spent.clear();
    for (std::size_t k = 0; k < part.size(); ++k) spent.push_back(slowness[k] * part[k] / all);
    pace.learn(division, frame_of(spent, colocated));
  }
  return spent;
}

}  // namespace

TEST_CASE("Renderers that took longer than others are told to, until all take as long") {
  for (const auto& slowness : {std::vector{1.0, 2.0, 1.0, 1.0, 1.1}, std::vector{1.0, 5.0}}) {
    const std::vector<double> spent = learnt(slowness, false);
    const auto [least, most] = std::ranges::minmax(spent);
    CHECK(most < 1.15 * least);
  }
}

TEST_CASE("a rank that encodes as well draws less") {
  const std::vector<double> spent = learnt({1, 1, 1}, true);
  CHECK(spent[0] + 0.2 == Approx(spent[1]).epsilon(0.15));
}

TEST_CASE("frames without news of Renderers, or of another division, tell nothing") {
  Layout layout;
  layout.renderers = 4;
  MeasuredPace pace(layout);
  Division division;
  pace.tell(division);
  CHECK(division.dealt_to == 4);
  CHECK(division.pace.empty());
  pace.learn(division, frame_of({0, 0, 0, 0}, false));
  Division of_three;
  of_three.dealt_to = 3;
  pace.learn(of_three, frame_of({1, 2, 3, 4}, false));
  pace.tell(division);
  CHECK(division.pace.empty());
}
