#include "forecast/token_times.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ringsplat::app {
namespace {

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

}  // namespace

TokenTimes::TokenTimes(const Machine& machine, const Layout& layout, int slots, const Shares& shares,
                       const TokenCosts& costs)
    : shares_(shares), costs_(costs), colocated_(layout.placement == Placement::colocated) {
  const double start = costs.hop * std::ceil(std::log2(std::max(2, layout.ranks())));
  drawers_.assign(std::size_t(layout.renderers), {.token = start,
                                                  .drawn = start + machine.renderer.frame,
                                                  .ends = std::vector<double>(std::size_t(slots), 0.0)});
  gp_free_.assign(std::size_t(layout.gps), start + machine.gp.frame);
  gp_busy_.assign(gp_free_.size(), machine.gp.frame);
  encoding_.assign(gp_free_.size(), 0);
}

void TokenTimes::pass(std::size_t gp, const std::vector<std::size_t>& layers, double encoding) {
  const double ready = encode(gp, encoding);
  double passed = ready, software = ready;
  for (std::size_t r = 0; r < drawers_.size(); ++r) {
    if (!shares_.has_tile[r]) continue;
    const double here = std::max({drawers_[r].token, ready, software});
    software += costs_.software;
    passed = std::max(passed, pass_on(gp, r, here, layers));
  }
  gp_busy_[gp] += software - ready;
  gp_free_[gp] = std::max(passed, software);
}

double TokenTimes::busiest_gp() const { return *std::max_element(gp_busy_.begin(), gp_busy_.end()); }

/// When the bundle is ready. A Renderer on the same rank first draws the payload that it has begun.
double TokenTimes::encode(std::size_t gp, double seconds) {
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
TokenTimes::Work TokenTimes::work_of(std::size_t renderer, const std::vector<std::size_t>& layers) const {
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

/// When the token that is with a prepared bundle leaves it.
double TokenTimes::pass_on(std::size_t gp, std::size_t renderer, double here,
                           const std::vector<std::size_t>& layers) {
  Drawer& d = drawers_[renderer];
  const Work work = work_of(renderer, layers);
  // A GP with a rank of its own computes nothing while tokens come to its slice.
  double leaves = here;
  if (colocated_) leaves += wait_for_renderer(gp, here);
  if (work.slices > 0) {
    double arrives = leaves + costs_.hops.payload * costs_.hop;
    arrives += std::max(wait_for_renderer(renderer, arrives), wait_for_gp(renderer, arrives));
    paint(d, arrives);
    const double seconds = work.now + costs_.message + (d.payloads == 0 ? costs_.table : 0);
    // The payload is accepted once one of as many before it as there are slots is drawn.
    double& slot = d.ends[d.payloads++ % d.ends.size()];
    leaves = std::max(arrives, slot) + costs_.hops.accept * costs_.hop;
    if (colocated_) leaves += wait_for_renderer(gp, leaves);
    d.drawn = slot = std::max(arrives, d.drawn) + seconds;
    d.last = seconds;
    d.busy += seconds + work.later;
    d.owed += work.later;
    make_room(d, work.slices);
  }
  d.token = leaves + costs_.hops.token * costs_.hop;
  return leaves;
}

/// How long a message waits that comes to the Renderer's rank.
double TokenTimes::wait_for_renderer(std::size_t renderer, double now) const {
  if (renderer >= drawers_.size()) return 0;
  const Drawer& d = drawers_[renderer];
  if (d.drawn > now) return 0.5 * std::min(d.last, costs_.longest_piece);
  return d.owed > 0 ? 0.5 * costs_.painting_piece : 0;
}

/// The same for a GP that encodes its next bundle beside a Renderer.
double TokenTimes::wait_for_gp(std::size_t gp, double now) const {
  const bool encodes =
      colocated_ && gp < gp_free_.size() && now >= gp_free_[gp] && now < gp_free_[gp] + encoding_[gp];
  return encodes ? 0.5 * std::min(encoding_[gp], costs_.longest_piece) : 0;
}

}  // namespace ringsplat::app
