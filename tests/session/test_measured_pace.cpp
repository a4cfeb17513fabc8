#include <algorithm>
#include <deque>

#include "session/measured_pace.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

/// A frame in which each Renderer draws for its part of the work, and rank 1 encodes as well.
FrameStats frame_of(const std::vector<double>& drawing, bool colocated) {
  FrameStats stats;
  for (const double seconds : drawing) {
    stats.renderers.emplace_back().drawing = 0.9 * seconds;
    stats.renderers.back().compositing = 0.1 * seconds;
  }
  stats.gps.resize(2);
  if (colocated) stats.gps[1].computing = 0.2;
  return stats;
}

/// What each takes once what was measured is told, when Renderer k takes slowness[k] seconds for what the
/// others do in one, and work goes to each by its pace. So many frames are on their way at a time.
std::vector<double> learnt(const std::vector<double>& slowness, bool colocated, std::size_t in_flight = 1) {
  Layout layout;
  layout.gps = 2;
  layout.renderers = int(slowness.size());
  if (colocated) layout.placement = Placement::colocated;
  MeasuredPace pace(layout);
  std::vector<double> spent;
  std::deque<Division> announced;
  for (int frame = 0; frame < 60; ++frame) {
    while (announced.size() < in_flight) pace.tell(announced.emplace_back());
    const Division division = announced.front();
    announced.pop_front();
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
  for (const auto& slowness : {std::vector{1.0, 2.0, 1.0, 1.0, 1.1}, std::vector{1.0, 3.0}}) {
    for (const std::size_t in_flight : {1, 2, 8}) {
      const std::vector<double> spent = learnt(slowness, false, in_flight);
      const auto [least, most] = std::ranges::minmax(spent);
      CHECK(most < 1.25 * least);
    }
  }
}

TEST_CASE("a rank that encodes as well draws less, and rank 0 never more for it") {
  const std::vector<double> spent = learnt({1, 1, 1}, true);
  CHECK(spent[1] + 0.2 == Approx(spent[2]).epsilon(0.2));
  CHECK(spent[0] < spent[2]);
}

TEST_CASE("what is told stays while it is about right, and who draws nothing is forgotten") {
  Layout layout;
  layout.renderers = 3;
  MeasuredPace pace(layout);
  const auto told = [&] {
    Division division;
    pace.tell(division);
    return division;
  };
  told();
  for (int frame = 0; frame < 20; ++frame) pace.learn(told(), frame_of({2, 1, 1}, false));
  const Division before = told();
  REQUIRE(before.pace.size() == 3);
  CHECK(before.pace[0] > 1.5 * before.pace[1]);
  pace.learn(before, frame_of({1.02, 1, 0.98}, false));
  CHECK(told().pace == before.pace);
  for (int frame = 0; frame < 20; ++frame) pace.learn(told(), frame_of({0, 1, 1}, false));
  CHECK(told().pace[0] < 1.5 * told().pace[1]);
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
