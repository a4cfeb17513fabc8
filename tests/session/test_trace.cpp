// A node's record, the comparison of clocks, and the trace of whole frames in one process.
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "record/trace.hpp"
#include "support/catch.hpp"
#include "support/scenes.hpp"
#include "support/trace_checks.hpp"

using namespace ringsplat;
using namespace ringsplat::test;
using nlohmann::json;

namespace {

constexpr double us = 1e-6;
const NodeId gp_0{Role::gp, 0};

/// Three frames of a soft ball, with their statistics and trace.
struct Traced {
  json trace;
  std::vector<FrameStats> stats;
};

Traced trace_loopback(const Layout& layout, LoopbackOptions loopback, int look_ahead) {
  const auto source = synth_source("ball", make_grid({20, 22, 18}));
  SoloCollectives solo;
  FrameSpec spec{.how = Splats{}};
  spec.shown.width = spec.shown.height = 64;
  spec.division.region_size = 16;
  spec.shown.transfer_function = ramp(20, 255, 0.3);
  Traced traced;
  Trace trace;
  ProtocolOptions protocol;
  protocol.look_ahead = look_ahead;
  protocol.trace = &trace;
  Director director{[&, next = 0]() mutable -> std::optional<FrameSpec> {
                      if (next == 3) return std::nullopt;
                      spec.shown.camera.azimuth = 50.0 * next++;
                      return spec;
                    },
                    [&](FrameResult&& r) { traced.stats.push_back(std::move(r.stats)); }};
  trace.compare_clocks(solo);
  render_directed(*source, {}, layout, std::move(director), loopback, protocol);
  trace.compare_clocks(solo);
  traced.trace = json::parse(to_chrome_trace(trace.gather(solo), layout));
  return traced;
}

double seconds(const Traced& traced, const std::string& node, std::initializer_list<const char*> spans) {
  double sum = 0;
  for (const char* span : spans) sum += busy_seconds(traced.trace, node, span);
  return sum;
}

}  // namespace

TEST_CASE("pieces of a slice's work become one span, and only short gaps are bridged") {
  NodeTrace node(gp_0);
  node.add(Activity::slice, 0, 3, 0, 100 * us);
  node.add(Activity::wait_for_token, 0, 2, 100 * us, 105 * us);
  node.add(Activity::slice, 0, 3, 105 * us, 200 * us);
  node.add(Activity::wait_for_token, 0, 2, 200 * us, 230 * us);
  node.add(Activity::wait_for_token, 0, 2, 230 * us, 260 * us);
  node.add(Activity::slice, 0, 3, 260 * us, 300 * us);
  node.add(Activity::slice, 0, 4, 300 * us, 310 * us);
  const auto& spans = node.record().spans;
  REQUIRE(spans.size() == 4);
  CHECK(spans[0].begin == 0);
  CHECK(spans[0].end == Approx(200 * us));
  CHECK(spans[0].busy == Approx(195 * us));
  CHECK(spans[1].activity == Activity::wait_for_token);
  CHECK(spans[1].busy == Approx(60 * us));
  CHECK(spans[2].step == 3);
  CHECK(spans[3].step == 4);
}

TEST_CASE("a full record stops growing and says so") {
  NodeTrace node(gp_0, 10);
  for (int k = 0; k < 10; ++k) {
    node.add(Activity::draw, 0, k, k, k + 0.5);
    node.mark(Moment::take_payload, 0, k, 0, k);
  }
  CHECK_FALSE(node.record().full);
  node.mark(Moment::take_payload, 0, 10, 0, 10);
  CHECK(node.record().full);
  for (int k = 10; k < 1000; ++k) node.add(Activity::draw, 0, k, k, k + 0.5);
  CHECK(node.record().spans.size() == 10);
  CHECK(node.record().marks.size() == 10);
}

TEST_CASE("a clock's offset is found within the bounds that its rounds give") {
  std::mt19937 random(5);
  std::exponential_distribution<double> late(1 / 300e-6);
  for (const double ahead : {0.0, 1234.5, -0.25}) {
    std::vector<GatherTimes> mine, of_0;
    double now = 10;
    for (int round = 0; round < 16; ++round) {
      const double enter_0 = now + late(random), enter = now + late(random);
      const double all = std::max(enter_0, enter);
      const double leave_0 = all + late(random), leave = all + late(random);
      of_0.push_back({enter_0, leave_0});
      mine.push_back({enter + ahead, leave + ahead});
      now = std::max(leave_0, leave);
    }
    const ClockOffset found = estimate_offset(mine, of_0);
    CHECK_FALSE(found.common);
    CHECK(std::abs(found.offset - ahead) <= found.uncertainty);
    CHECK(found.uncertainty < 600e-6);
    CHECK(found.uncertainty > 0);
  }
}

TEST_CASE(
    "the trace of a run is whole: spans nest, flows have two ends, seconds are those of the statistics") {
  struct Run {
    Layout layout;
    LoopbackOptions loopback;
    int look_ahead;
  };
  const Run runs[] = {{{3, 2}, {}, 1},
                      {{2, 2, Placement::colocated}, {}, 3},
                      {{1, 1}, {}, 1},
                      {{4, 3}, {.seed = 3, .reorder = true, .max_delay = 4}, 2},
                      {mesh_layout(2, 2, 2), {}, 1}};
  for (const Run& run : runs) {
    const Layout& layout = run.layout;
    INFO(layout.gps << " GPs, " << layout.renderers << " Renderers, look-ahead " << run.look_ahead);
    const Traced traced = trace_loopback(layout, run.loopback, run.look_ahead);
    check_trace(traced.trace, layout.gps, layout.renderers, layout.ranks());

    std::uint64_t tokens = 0, payloads = 0;
    for (const auto& frame : traced.stats) {
      tokens += frame.total().tokens_passed;
      payloads += frame.total().payloads_sent;
    }
    REQUIRE(payloads > 0);
    CHECK(flows(traced.trace, "token") == tokens);
    CHECK(flows(traced.trace, "payload") == payloads);
    CHECK(count_events(traced.trace, "b", "frame") == 3);

    const auto sum = [&](const std::vector<NodeStats> FrameStats::*side, int index, double NodeStats::*part) {
      double all = 0;
      for (const auto& frame : traced.stats) all += (frame.*side)[std::size_t(index)].*part;
      return all;
    };
    const auto rounding = Approx::custom().epsilon(1e-4).margin(2e-6);
    for (int g = 0; g < layout.gps; ++g) {
      const std::string node = to_string(NodeId{Role::gp, g});
      const double computing = sum(&FrameStats::gps, g, &NodeStats::computing);
      CHECK(seconds(traced, node, {"slice"}) == rounding(computing));
      const double waiting = sum(&FrameStats::gps, g, &NodeStats::waiting_for_token) +
                             sum(&FrameStats::gps, g, &NodeStats::sending);
      CHECK(seconds(traced, node, {"wait for token", "send"}) <= waiting * (1 + 1e-4) + 2e-6);
    }
    for (int r = 0; r < layout.renderers; ++r) {
      const std::string node = to_string(NodeId{Role::renderer, r});
      CHECK(seconds(traced, node, {"draw"}) == rounding(sum(&FrameStats::renderers, r, &NodeStats::drawing)));
      CHECK(seconds(traced, node, {"composite"}) ==
            rounding(sum(&FrameStats::renderers, r, &NodeStats::compositing)));
      CHECK(seconds(traced, node, {"deliver"}) ==
            rounding(sum(&FrameStats::renderers, r, &NodeStats::delivering)));
    }
  }
}

TEST_CASE("a flow whose other end was not recorded is left out") {
  Trace::Gathered all;
  all.offsets.resize(2);
  all.nodes.resize(2);
  all.nodes[0].node = gp_0;
  all.nodes[0].full = true;
  all.nodes[1].node = {Role::gp, 1};
  all.nodes[0].marks = {{1.0, 0, 1, 0, Moment::pass_token}, {2.0, 0, 3, 0, Moment::pass_token}};
  all.nodes[1].marks = {{1.5, 0, 1, 0, Moment::take_token}};
  const json trace = json::parse(to_chrome_trace(all, {.gps = 2, .renderers = 1}));
  CHECK(flows(trace, "token") == 1);
  CHECK(count_events(trace, "X", "pass token") == 2);
  CHECK(trace["otherData"]["full"] == json::array({"GP 0"}));
}
