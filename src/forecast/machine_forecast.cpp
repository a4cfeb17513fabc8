#include "forecast/machine_forecast.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

#include "forecast/probe.hpp"
#include "forecast/token_times.hpp"
#include "frame/work_dealing.hpp"
#include "simulate/work_costs.hpp"

namespace ringsplat::app {
namespace {

VolumeSketch sketch_of(VolumeSource& source) {
  const Grid& grid = source.grid();
  VolumeSketch sketch(grid.dims);
  std::vector<std::byte> slice(grid.slice_bytes(Axis::z));
  for (int z = 0; z < sketch.points.z; ++z) {
    source.read_slices(sketch.voxel(2, z), 1, slice);
    visit_type(grid.type, [&](auto zero) {
      using T = decltype(zero);
      for (int y = 0; y < sketch.points.y; ++y)
        for (int x = 0; x < sketch.points.x; ++x) {
          T value;
          const auto voxel =
              std::size_t(sketch.voxel(1, y)) * std::size_t(grid.dims.x) + std::size_t(sketch.voxel(0, x));
          std::memcpy(&value, slice.data() + voxel * sizeof(T), sizeof(T));
          sketch.values[sketch.index({x, y, z})] = static_cast<float>(value);
        }
    });
  }
  return sketch;
}

/// Seconds of messages, software on both sides included.
struct Messages {
  double small = 0;     ///< from sending one without a payload to having it
  double software = 0;  ///< a GP's for a token, its payload and accept
  double bandwidth = 1;
  explicit Messages(const Machine& m) {
    constexpr double bytes = 64;
    const double send = sending_seconds(m, bytes);
    small = send + m.platform.latency + bytes / m.platform.bandwidth + m.message.receive;
    software = 2 * (send + m.message.receive) + m.gp.token;
    bandwidth = m.platform.bandwidth;
  }
};

/// What a host sends and receives at most, of all that is sent, when ranks fill the hosts one after another
/// and each GP sends every Renderer as much; and what leaves a host at all.
struct Traffic {
  double most_of_host = 0, between_hosts = 0;
  Traffic(const Machine& m, const Layout& layout) {
    const int ranks = layout.ranks(), hosts = m.platform.hosts > 0
                                                  ? m.platform.hosts
                                                  : (ranks + m.platform.cores - 1) / m.platform.cores;
    std::vector<double> gps(std::size_t(hosts), 0.0), renderers = gps;
    const auto host_of = [&](int rank) {
      return std::size_t(m.platform.hosts > 0 ? std::int64_t{rank} * hosts / ranks : rank / m.platform.cores);
    };
    for (int g = 0; g < layout.gps; ++g) gps[host_of(layout.rank_of({Role::gp, g}))] += 1.0 / layout.gps;
    for (int r = 0; r < layout.renderers; ++r)
      renderers[host_of(layout.rank_of({Role::renderer, r}))] += 1.0 / layout.renderers;
    for (std::size_t h = 0; h < gps.size(); ++h) {
      const double out = gps[h] * (1 - renderers[h]), in = renderers[h] * (1 - gps[h]);
      most_of_host = std::max({most_of_host, out, in});
      between_hosts += out;
    }
  }
};

}  // namespace

struct MachineForecast::View {
  WorkCosts costs;
  FrameGeometry geometry;
  WorkEstimate whole;
  std::vector<WorkEstimate> layers;
  bool paints_later = false;  ///< pixels, while no payload is there

  /// Of a geometry whose regions are dealt.
  Shares shares(const FrameGeometry& g, int renderers) const {
    const std::vector none(layers.size(), std::vector<double>(std::size_t(renderers), 0.0));
    Shares s{none, none, std::vector<bool>(std::size_t(renderers), false),
             std::vector<double>(std::size_t(renderers), 0.0)};
    const RegionOwners owners = g.owners(renderers);
    for (int region = 0; region < g.regions.count(); ++region) {
      const int owner = owners.of(region);
      if (owner == RegionOwners::nobody) continue;
      const auto k = std::size_t(owner);
      const PixelRect rect = g.regions.rect(region);
      const PartWork all = whole.of(rect);
      s.has_tile[k] = true;
      if (all.layers != 0) s.pixels[k] += double(rect.width()) * rect.height();
      for (std::size_t layer = 0; layer < layers.size(); ++layer)
        if ((all.layers >> layer & 1) != 0) {
          const PartWork part = layers[layer].of(rect);
          const double later = paints_later ? part.painted : 0;
          s.of_layer[layer][k] += (part.seconds - later) / whole.slices_of_layer();
          s.painted[layer][k] += later / whole.slices_of_layer();
        }
    }
    return s;
  }
};

MachineForecast::~MachineForecast() = default;

MachineForecast::MachineForecast(VolumeSource& source, FrameSpec frame, const TransferFunctionChoice& choice,
                                 const std::vector<Camera>& views, const Machine& machine,
                                 double voxel_weight, int ranks, const ProtocolOptions& protocol)
    : machine_(machine), protocol_(protocol), frame_(std::move(frame)) {
  const Grid grid = source.grid();
  frame_.shown.transfer_function = function_for(source, choice);
  check(frame_);
  const bool sheets = std::holds_alternative<Sheets>(frame_.how);
  const WorkCosts usual = sheets ? sheet_costs(machine, voxel_weight) : splat_costs(machine, voxel_weight);
  // A splat of a run, and what its run's head adds.
  constexpr double bytes_of_splat = 11;
  bytes_of_voxel_ = voxel_weight * (sheets ? double(size_of(grid.type)) : bytes_of_splat);
  const VolumeSketch sketch = sketch_of(source);
  ShownPoints points;
  for (const Camera& camera : views) {
    frame_.shown.camera = camera;
    frame_.division.dealt_to = ranks;
    FrameGeometry g = make_geometry(frame_, grid);
    if (!sheets) g.reach = narrowed(g.reach, voxel_weight);
    const WorkCosts costs = costs_in(g, usual);
    const auto shown = points.of(sketch, frame_.shown.transfer_function, shown_blocks(g, costs));
    const int factor = frame_.shown.reduction.factor;
    WorkEstimate whole(g, sketch, shown, costs, factor);
    std::vector<WorkEstimate> layers;
    for (int layer = 0; layer < whole.layers(); ++layer)
      layers.emplace_back(g, sketch, shown, costs, factor, layer);
    views_.push_back(
        std::make_unique<View>(View{costs, std::move(g), std::move(whole), std::move(layers), sheets}));
  }
}

FrameCosts MachineForecast::costs() const {
  FrameCosts costs;
  costs.frame = machine_.gp.frame;
  costs.slices = 0;
  const double share = 1.0 / double(views_.size());
  for (const auto& view : views_) {
    const FrameGeometry& g = view->geometry;
    costs.slices += share * g.slices;
    costs.visible_voxels += share * view->whole.visible_voxels();
    for (int step = 0; step < g.slices; ++step)
      costs.gp += share * (machine_.gp.slice + view->whole.slice_seconds(step));
    costs.columns = g.regions.columns();
    costs.region.resize(std::max(costs.region.size(), std::size_t(g.regions.count())));
    for (int region = 0; region < g.regions.count(); ++region)
      costs.region[std::size_t(region)] += share * view->whole.of(g.regions.rect(region)).seconds;
  }
  return costs;
}

Prediction MachineForecast::predict(const Layout& layout) const {
  Prediction p;
  p.layout = layout;
  for (const auto& view : views_) {
    const Prediction one = predict(*view, layout);
    const double share = 1.0 / double(views_.size());
    p.seconds += share * one.seconds;
    p.gp += share * one.gp;
    p.renderer += share * one.renderer;
    p.tokens += share * one.tokens;
  }
  p.limit = p.gp >= p.renderer ? Limit::gps : Limit::renderers;
  return p;
}

/// As the program deals them (engine_parts/frame_plan.cpp).
void MachineForecast::deal(const View& view, const Layout& layout, FrameGeometry& g) const {
  const RegionForm form = std::holds_alternative<Sheets>(frame_.how) ? RegionForm::flat : RegionForm::square;
  const Division division{frame_.division.region_size, layout.renderers};
  lay_regions(g, division, form);
  if (even_enough(g, layout.renderers)) return;
  std::vector<double> busy;
  if (layout.placement == Placement::colocated)
    busy = busy_gps(view.whole, dealing_of(layout), layout.renderers, layout.renderers);
  WorkCosts costs = view.costs;
  costs.payload -= payload_message_seconds(machine_) * (1 - 1.0 / layout.bundle);
  deal_by_work(g, view.whole, costs, division, form, layout.renderers, busy);
}

Prediction MachineForecast::predict(const View& view, const Layout& layout) const {
  FrameGeometry g = view.geometry;
  deal(view, layout, g);
  const Shares shares = view.shares(g, layout.renderers);
  const Messages messages(machine_);
  const double hop = messages.small,
               table = std::holds_alternative<Sheets>(frame_.how) ? machine_.sheets.table : 0;
  const double message = payload_message_seconds(machine_);
  TokenTimes tokens(machine_, layout, protocol_.slots, shares,
                    {.slice = view.costs.payload - message,
                     .message = message,
                     .table = table,
                     .hop = hop,
                     .software = messages.software,
                     .longest_piece = machine_.poll_interval,
                     .painting_piece = painting_piece(machine_),
                     .hops = mean_hops(layout)});
  const SliceDealing dealing = dealing_of(layout);
  int bundles = 0;
  std::vector<std::size_t> layers;
  for (int step = 0; step < g.slices; ++bundles) {
    const int first = view.whole.slice_of(step);
    double encoding = 0;
    layers.clear();
    for (; step < g.slices && dealing.bundle_of(view.whole.slice_of(step)) == dealing.bundle_of(first);
         ++step) {
      layers.push_back(std::size_t(view.whole.layer_of(step)));
      encoding += machine_.gp.slice + view.whole.slice_seconds(step);
    }
    tokens.pass(std::size_t(dealing.owner_of(first)), layers, encoding);
  }
  Prediction p;
  for (std::size_t r = 0; r < tokens.drawers().size(); ++r) {
    const Drawer& d = tokens.drawers()[r];
    const double delivering = shares.pixels[r] * (machine_.renderer.pixel + 16 / messages.bandwidth);
    p.seconds = std::max({p.seconds, d.drawn + d.owed + delivering + hop, d.token});
    p.renderer = std::max(p.renderer, d.busy + delivering);
  }
  p.seconds = std::max(p.seconds, link_seconds(view, layout));
  p.gp = tokens.busiest_gp();
  p.tokens = 3 * hop * bundles;
  return p;
}

double MachineForecast::link_seconds(const View& view, const Layout& layout) const {
  const auto& platform = machine_.platform;
  if (platform.kind != PlatformKind::backbone && platform.kind != PlatformKind::fat_tree) return 0;
  const Traffic traffic(machine_, layout);
  const double bytes = view.whole.visible_voxels() * bytes_of_voxel_;
  const double shared =
      platform.backbone_bandwidth > 0 ? traffic.between_hosts * bytes / platform.backbone_bandwidth : 0;
  return std::max(traffic.most_of_host * bytes / platform.bandwidth, shared);
}

std::vector<Prediction> MachineForecast::predict_all(const std::vector<Layout>& layouts) const {
  constexpr std::size_t looked_at_first = 24;
  const std::size_t stride = std::max<std::size_t>(1, layouts.size() / looked_at_first);
  std::vector<Prediction> all;
  std::vector<bool> done(layouts.size(), false);
  std::size_t best = 0;
  double least = INFINITY;
  const auto try_it = [&](std::size_t k) {
    if (done[k]) return;
    done[k] = true;
    all.push_back(predict(layouts[k]));
    if (all.back().seconds < least) least = all.back().seconds, best = k;
  };
  for (std::size_t k = 0; k < layouts.size(); ++k)
    if (k % stride == 0 || layouts[k].placement == Placement::colocated) try_it(k);
  for (std::size_t step = stride / 2; step > 0; step /= 2)
    for (const std::size_t k : {best - std::min(best, step), std::min(best + step, layouts.size() - 1)})
      try_it(k);
  std::stable_sort(all.begin(), all.end(),
                   [](const Prediction& a, const Prediction& b) { return a.seconds < b.seconds; });
  return all;
}

std::vector<Prediction> MachineForecast::predict_bundles(const std::vector<Layout>& layouts) const {
  constexpr int most = 64;
  constexpr double too_slow = 1.02, as_fast = 1.01;
  std::vector<std::vector<Prediction>> tried;
  double least = INFINITY;
  for (int bundle = 1; bundle <= most; bundle *= 2) {
    tried.push_back(predict_all(in_bundles(layouts, bundle)));
    const double seconds = tried.back().front().seconds;
    least = std::min(least, seconds);
    if (seconds > too_slow * least) break;
  }
  return *std::find_if(tried.begin(), tried.end(),
                       [&](const auto& all) { return all.front().seconds <= as_fast * least; });
}

std::vector<Layout> rings_on_machine(int ranks) {
  std::vector<Layout> layouts;
  for (int renderers = 1; renderers < ranks; ++renderers)
    layouts.push_back({.gps = ranks - renderers, .renderers = renderers});
  for (int renderers = ranks; renderers > ranks / 16 && renderers > 0; renderers /= 2)
    layouts.push_back({.gps = ranks, .renderers = renderers, .placement = Placement::colocated});
  return layouts;
}

}  // namespace ringsplat::app
