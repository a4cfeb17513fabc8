#include "forecast/forecast.hpp"

#include <cmath>
#include <utility>

#include "net/mesh.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "simulate/meter.hpp"

namespace ringsplat::app {
namespace {

/// How one Renderer goes through the frame; times are seconds since its announcement.
struct Drawer {
  double token = 0;          ///< when its token has come from the slice before
  double drawn = 0;          ///< when all payloads that came are drawn
  std::vector<double> ends;  ///< of the last payloads, as many as there are slots
  std::size_t payloads = 0;
  int kept = 0;     ///< slices that are not painted
  double owed = 0;  ///< seconds of painting left for later
  double last = 0;  ///< seconds of the last payload
  double busy = 0;  ///< seconds in sum
};

/// A Renderer paints while no payload is there.
void paint(Drawer& d, double until) {
  if (d.owed <= 0 || until <= d.drawn) return;
  const double painted = std::min(d.owed, until - d.drawn);
  d.owed -= painted;
  d.drawn += painted;
  if (d.owed <= 0) d.kept = 0;
}

/// With too many slices it paints all before it takes another.
void make_room(Drawer& d, int slices) {
  d.kept += slices;
  if (d.kept <= most_slices_kept) return;
  d.drawn += std::exchange(d.owed, 0);
  d.kept = 0;
}

/// One frame, followed from bundle to bundle.
class Walk {
 public:
  Walk(const Machine& machine, const Layout& layout, int slots, const Shares& shares, const TokenCosts& costs)
      : shares_(shares), costs_(costs), colocated_(layout.placement == Placement::colocated) {
    const double start = costs.hop * std::ceil(std::log2(std::max(2, layout.ranks())));
    drawers_.assign(std::size_t(layout.renderers), {.token = start,
                                                    .drawn = start + machine.renderer.frame,
                                                    .ends = std::vector<double>(std::size_t(slots), 0.0)});
    gp_free_.assign(std::size_t(layout.gps), start + machine.gp.frame);
    gp_busy_.assign(gp_free_.size(), machine.gp.frame);
    encoding_.assign(gp_free_.size(), 0);
    awake_.assign(std::size_t(layout.working_ranks()), -costs.wake);
  }

  void pass(const BundlePass& bundle) {
    const auto& [gp, layers, encoding] = bundle;
    const double ready = encode(gp, encoding);
    double passed = ready, software = ready;
    for (std::size_t r = 0; r < drawers_.size(); ++r) {
      if (!shares_.has_tile[r]) continue;
      const Work work = work_of(r, layers);
      if (costs_.in_layers && work.slices == 0) continue;
      const double here = std::max({drawers_[r].token, ready, software});
      software += costs_.software;
      passed = std::max(passed, pass_on(gp, r, here, work));
    }
    gp_busy_[gp] += software - ready;
    gp_free_[gp] = costs_.in_layers ? ready : std::max(passed, software);  // layers are prepared ahead
  }

  /// After all slices: Renderers paint what is left and deliver their pixels.
  void deliver() {
    for (std::size_t r = 0; r < drawers_.size(); ++r) {
      Drawer& d = drawers_[r];
      const double delivering = shares_.pixels[r] * costs_.pixel;
      d.drawn += std::exchange(d.owed, 0) + delivering;
      d.busy += delivering;
    }
  }

  TokenTimes times(const Layout& layout) const {
    TokenTimes t{.busiest_gp = *std::max_element(gp_busy_.begin(), gp_busy_.end()),
                 .busy_ranks = std::vector<double>(std::size_t(layout.ranks()), 0.0)};
    const auto add = [&](Role role, std::size_t k, double seconds) {
      t.busy_ranks[std::size_t(layout.rank_of({role, int(k)}))] += seconds;
    };
    for (std::size_t g = 0; g < gp_busy_.size(); ++g) add(Role::gp, g, gp_busy_[g]);
    for (std::size_t r = 0; r < drawers_.size(); ++r) {
      const Drawer& d = drawers_[r];
      add(Role::renderer, r, d.busy);
      t.busiest_renderer = std::max(t.busiest_renderer, d.busy);
      t.end = std::max({t.end, d.drawn + costs_.hop, d.token});
    }
    t.end += costs_.end;
    return t;
  }

 private:
  struct Work {
    double now = 0, later = 0;
    int slices = 0;
  };
  /// When the bundle is ready. A Renderer on the same rank first draws the payload that it has begun.
  double encode(std::size_t gp, double seconds) {
    double begun = gp_free_[gp];
    gp_busy_[gp] += seconds;
    encoding_[gp] = seconds;
    if (colocated_ && gp < drawers_.size()) {
      Drawer& beside = drawers_[gp];
      paint(beside, begun);
      begun += std::min(std::max(0.0, beside.drawn - begun), 0.5 * beside.last);
      beside.drawn = std::max(beside.drawn, begun) + seconds;
    }
    return begun + seconds;
  }

  /// A Renderer's work for the slices' payload, its message left out.
  Work work_of(std::size_t renderer, const std::vector<std::size_t>& layers) const {
    Work work;
    for (const std::size_t layer : layers) {
      const double now = shares_.of_layer[layer][renderer], later = shares_.painted[layer][renderer];
      if (now + later <= 0) continue;
      work.now += now + costs_.slice;
      work.later += later;
      ++work.slices;
    }
    return work;
  }

  /// When the token that is with a prepared bundle leaves it. What stays on a rank waits for its work only.
  double pass_on(std::size_t gp, std::size_t renderer, double here, const Work& work) {
    Drawer& d = drawers_[renderer];
    const bool stays = colocated_ && gp == renderer, only_gp = gp_free_.size() == 1;
    double leaves = here;
    if (colocated_ || here <= d.token) leaves += wait_at_gp(gp, here, only_gp);
    if (work.slices > 0) {
      double arrives = leaves + (stays ? 0 : costs_.hops.payload * costs_.hop);
      arrives += std::max(wait_for_renderer(renderer, arrives, stays), wait_for_gp(renderer, arrives));
      paint(d, arrives);
      const double seconds = work.now + costs_.message + (d.payloads == 0 ? costs_.table : 0);
      // The payload is accepted once one of as many before it as there are slots is drawn.
      double& slot = d.ends[d.payloads++ % d.ends.size()];
      leaves = std::max(arrives, slot) + (stays ? 0 : costs_.hops.accept * costs_.hop);
      leaves += wait_at_gp(gp, leaves, stays);
      d.drawn = slot = std::max(arrives, d.drawn) + seconds;
      d.last = seconds;
      d.busy += seconds + work.later;
      d.owed += work.later;
      make_room(d, work.slices);
    }
    d.token = leaves + (only_gp ? 0 : costs_.hops.token * costs_.hop);
    return leaves;
  }

  /// How long a token or an accept waits. A GP with a rank of its own computes nothing while they come.
  double wait_at_gp(std::size_t gp, double now, bool awake) {
    if (colocated_) return wait_for_renderer(gp, now, awake);
    return awake ? 0 : wake(gp, now);
  }

  /// How long a message waits that comes to the Renderer's rank; `awake`: from that rank.
  double wait_for_renderer(std::size_t renderer, double now, bool awake) {
    if (renderer < drawers_.size()) {
      const Drawer& d = drawers_[renderer];
      if (d.drawn > now) return 0.5 * std::min(d.last, costs_.longest_piece);
      if (d.drawn + d.owed > now) return 0.5 * costs_.painting_piece;
    }
    return awake ? 0 : wake(renderer + (colocated_ ? 0 : gp_free_.size()), now);
  }

  /// How long a message waits that comes to a rank without work, which others may have woken already.
  double wake(std::size_t rank, double now) {
    double& awake = awake_[rank];
    if (now > awake || now < awake - costs_.wake) awake = now + costs_.wake;
    return awake - now;
  }

  /// The same for a GP that encodes its next bundle beside a Renderer.
  double wait_for_gp(std::size_t gp, double now) const {
    const bool encodes =
        colocated_ && gp < gp_free_.size() && now >= gp_free_[gp] && now < gp_free_[gp] + encoding_[gp];
    return encodes ? 0.5 * std::min(encoding_[gp], costs_.longest_piece) : 0;
  }

  const Shares& shares_;
  TokenCosts costs_;
  bool colocated_;
  std::vector<Drawer> drawers_;
  std::vector<double> gp_free_, gp_busy_, encoding_;  ///< by GP; the last bundle's encoding
  std::vector<double> awake_;                         ///< by rank: when it goes on that was woken last
};

int hops(const Layout& mesh, NodeId from, NodeId to) { return int(route(mesh, from, to).size()); }

}  // namespace

TokenTimes token_times(const Machine& machine, const Layout& layout, int slots, const Shares& shares,
                       const TokenCosts& costs, const std::vector<BundlePass>& bundles) {
  Walk walk(machine, layout, slots, shares, costs);
  for (const BundlePass& bundle : bundles) walk.pass(bundle);
  walk.deliver();
  return walk.times(layout);
}

MeanHops mean_hops(const Layout& layout) {
  if (!layout.routed()) return {};
  MeanHops mean{0, 0, 0};
  for (int g = 0; g < layout.gps; ++g) {
    const NodeId gp{Role::gp, g};
    mean.token += hops(layout, gp, {Role::gp, (g + 1) % layout.gps}) / double(layout.gps);
    for (int r = 0; r < layout.renderers; ++r) {
      const NodeId renderer{Role::renderer, r};
      const double pairs = double(layout.gps) * layout.renderers;
      mean.payload += hops(layout, gp, renderer) / pairs;
      mean.accept += hops(layout, renderer, gp) / pairs;
    }
  }
  return mean;
}

TokenCosts token_costs(const Machine& m, const Layout& layout) {
  constexpr double bytes = 64, bytes_of_pixel = 16;
  const double send = sending_seconds(m, bytes);
  return {.message = payload_message_seconds(m),
          .table = m.sheets.table,
          .hop = send + m.platform.latency + bytes / m.platform.bandwidth + m.message.receive,
          .wake = m.message.wake,
          .software = 2 * (send + m.message.receive) + m.gp.token,
          .longest_piece = m.poll_interval,
          .painting_piece = painting_piece(m),
          .pixel = m.renderer.pixel + bytes_of_pixel / m.platform.bandwidth,
          .hops = mean_hops(layout)};
}

}  // namespace ringsplat::app
