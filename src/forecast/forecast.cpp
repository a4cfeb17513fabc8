#include "forecast/forecast.hpp"

#include <tuple>

#include "program/layouts.hpp"
#include "scene/scene.hpp"
#include "simulate/meter.hpp"

namespace ringsplat::app {
namespace {

constexpr std::int64_t most_voxels = std::int64_t{1} << 24;
constexpr int sections_of_large_volumes = 3;

/// All voxels of small volumes; of others sections.
void visit_some(VolumeSource& source, const RowVisitor& visit) {
  const Grid& grid = source.grid();
  if (grid.voxels() <= most_voxels) return visit_slices(source, 0, grid.dims.z, visit);
  const auto in_slice = std::int64_t(grid.slice_voxels(Axis::z));
  const int wanted = int(std::max<std::int64_t>(1, most_voxels / sections_of_large_volumes / in_slice));
  const int thick = std::min(wanted, std::max(1, grid.dims.z / sections_of_large_volumes));
  const int count = std::min(sections_of_large_volumes, grid.dims.z);
  for (int k = 0; k < count; ++k) {
    const int middle = int((2 * std::int64_t(k) + 1) * grid.dims.z / (2 * count));
    visit_slices(source, std::clamp(middle - thick / 2, 0, grid.dims.z - thick), thick, visit);
  }
}

VolumeSketch sketch_of(VolumeSource& source) {
  const Grid& grid = source.grid();
  VolumeSketch sketch(grid.dims);
  std::vector<std::byte> slice(grid.slice_bytes(Axis::z));
  for (int z = 0; z < sketch.points.z; ++z) {
    source.read_slices(sketch.voxel(2, z), 1, slice);
    const auto points = points_of(sketch, {.axis = Axis::z,
                                           .width = grid.dims.x,
                                           .height = grid.dims.y,
                                           .type = grid.type,
                                           .values = slice.data()});
    std::copy(points.begin(), points.end(), sketch.values.begin() + std::ptrdiff_t(sketch.index({0, 0, z})));
  }
  return sketch;
}

}  // namespace

TransferFunction function_for(VolumeSource& source, const TransferFunctionChoice& choice) {
  Shown shown;
  std::vector<std::byte> read;  // once: files may have to be decoded
  visit_some(source, [&](auto slice, int) { read.insert(read.end(), slice.begin(), slice.end()); });
  const Pass pass = [&](const RowVisitor& visit) { visit(read, source.grid().dims.x); };
  choice.make(describe_values(source.grid(), source.notes(), pass), shown);
  return shown.transfer_function;
}

struct Forecast::View {
  FrameSpec spec;
  WorkCosts costs;
  FrameGeometry geometry;
  WorkEstimate whole;
  std::vector<WorkEstimate> layers;

  /// Of a geometry whose regions are dealt. Sheets' pixels are painted while no payload is there.
  Shares shares(const FrameGeometry& g, int renderers) const {
    const bool paints_later = std::holds_alternative<Sheets>(spec.how);
    const std::vector none(layers.size(), std::vector<double>(std::size_t(renderers), 0.0));
    Shares s{none, none, std::vector<bool>(std::size_t(renderers), false),
             std::vector<double>(std::size_t(renderers), 0.0)};
    const std::vector<int> owners = g.owners(renderers);
    const double copies = copies_of_blocks(g, costs.block);
    for (int region = 0; region < g.regions.count(); ++region) {
      const int owner = owners[std::size_t(region)];
      if (owner == nobody) continue;
      const auto k = std::size_t(owner);
      const PixelRect rect = g.regions.rect(region);
      const PartWork all = whole.of(rect);
      s.has_tile[k] = true;
      if (all.layers != 0) s.pixels[k] += double(rect.width()) * rect.height();
      for (std::size_t layer = 0; layer < layers.size(); ++layer)
        if ((all.layers >> layer & 1) != 0) {
          const PartWork part = layers[layer].of(rect);
          const double later = paints_later ? part.painted : 0;
          // A block comes once for all regions of a part.
          const double now = g.in_parts ? copies * (part.inside - part.painted) : part.seconds - later;
          s.of_layer[layer][k] += now / whole.slices_of_layer();
          s.painted[layer][k] += later / whole.slices_of_layer();
        }
    }
    return s;
  }

  /// Voxels that Renderers get; one that reaches several regions counts for each.
  double voxels_drawn(const FrameGeometry& g) const {
    double seconds = 0;
    for (int region = 0; region < g.regions.count(); ++region) {
      const PartWork part = whole.of(g.regions.rect(region));
      seconds += part.seconds - part.painted;
    }
    return costs.voxel > 0 ? seconds / costs.voxel : 0;
  }
};

Forecast::~Forecast() = default;

Forecast::Forecast(VolumeSource& source, FrameSpec frame, const TransferFunctionChoice& choice,
                   const std::vector<Camera>& views, const Machine& machine, double voxel_weight, int ranks,
                   const ProtocolOptions& protocol)
    : machine_(machine),
      protocol_(protocol),
      voxel_weight_(voxel_weight),
      sheets_(std::holds_alternative<Sheets>(frame.how)),
      setup_{.grid = source.grid(), .slices = nullptr},
      dealer_(setup_) {
  frame.shown.transfer_function = function_for(source, choice);
  check(frame);
  const WorkCosts usual = sheets_ ? sheet_costs(machine, voxel_weight) : splat_costs(machine, voxel_weight);
  // A splat of a run, and what its run's head adds.
  constexpr double bytes_of_splat = 11;
  bytes_of_voxel_ = voxel_weight * (sheets_ ? double(size_of(setup_.grid.type)) : bytes_of_splat);
  setup_.sketch = std::make_shared<const VolumeSketch>(sketch_of(source));
  const VolumeSketch& sketch = *setup_.sketch;
  ShownPoints points;
  for (const Camera& camera : views) {
    frame.shown.camera = camera;
    frame.division.dealt_to = ranks;
    FrameGeometry g = make_geometry(frame, setup_.grid);
    if (!sheets_) g.reach = narrowed(g.reach, voxel_weight);
    const WorkCosts costs = costs_in(g, usual);
    const auto shown = points.of(sketch, frame.shown.transfer_function, shown_blocks(g, costs));
    const int factor = frame.shown.reduction.factor;
    WorkEstimate whole(g, sketch, shown, costs, factor);
    std::vector<WorkEstimate> layers;
    for (int layer = 0; layer < whole.layers(); ++layer)
      layers.emplace_back(g, sketch, shown, costs, factor, layer);
    views_.push_back(
        std::make_unique<View>(View{frame, costs, std::move(g), std::move(whole), std::move(layers)}));
  }
}

FrameWork Forecast::work() {
  const Layout alone{.gps = 1, .renderers = 1};
  FrameWork work{.items_name = sheets_ ? "blocks" : "splats", .frame = machine_.gp.frame};
  const double share = 1.0 / double(views_.size());
  for (const auto& view : views_) {
    const FrameGeometry g = dealt(*view, alone);
    work.visible_voxels += share * view->whole.visible_voxels();
    const double of_item = sheets_ ? view->costs.block * view->costs.block : 1 / voxel_weight_;
    work.items += share * view->voxels_drawn(g) / of_item;
    for (int step = 0; step < g.slices; ++step)
      work.gp += share * (machine_.gp.slice + view->whole.slice_seconds(step));
    work.renderer += share * predict(*view, alone).renderer;
  }
  return work;
}

Prediction Forecast::predict(const Layout& layout) {
  Prediction p;
  p.layout = layout;
  const double share = 1.0 / double(views_.size());
  for (const auto& view : views_) {
    const Prediction one = predict(*view, layout);
    for (const auto part : {&Prediction::gp, &Prediction::renderer, &Prediction::shared, &Prediction::tokens,
                            &Prediction::seconds})
      p.*part += share * one.*part;
  }
  const bool colocated = layout.placement == Placement::colocated;
  const double longest = colocated ? p.gp + p.renderer : std::max(p.gp, p.renderer);
  p.limit = p.shared > longest ? "the cores" : p.gp >= p.renderer ? "the GPs" : "the Renderers";
  return p;
}

FrameGeometry Forecast::dealt(const View& view, const Layout& layout) {
  FrameSpec spec = view.spec;
  spec.division.dealt_to = layout.renderers;
  FrameGeometry g = view.geometry;
  lay_regions(g, spec);
  setup_.gps = layout.gps;
  setup_.renderers = layout.renderers;
  setup_.bundle = layout.bundle;
  setup_.colocated = layout.placement == Placement::colocated;
  setup_.splat_costs = splat_costs(machine_, voxel_weight_, layout.bundle);
  setup_.sheet_costs = sheet_costs(machine_, voxel_weight_, layout.bundle);
  dealer_.use(setup_);
  dealer_.deal(spec, g);
  return g;
}

Prediction Forecast::predict(const View& view, const Layout& layout) {
  const FrameGeometry g = dealt(view, layout);
  const Shares shares = view.shares(g, layout.renderers);
  const Hosts hosts(machine_, layout);
  TokenCosts costs = token_costs(machine_, layout);
  costs.slice = view.costs.payload - costs.message;
  if (!sheets_) costs.table = 0;
  const bool share = hosts.share_cores();
  if (!share) costs.wake = 0;
  if (g.layers.slices > 0) {
    // A layer's pixel goes to who composites it, as four halves, and comes there.
    costs.end = costs.pixel * g.width * g.height / layout.renderers;
    costs.pixel = 2 * 8 / machine_.platform.bandwidth;
    costs.in_layers = true;
  }
  const SliceDealing dealing = dealing_of(layout);
  std::vector<BundlePass> bundles;
  for (int step = 0; step < g.slices;) {
    const int first = view.whole.slice_of(step);
    BundlePass& bundle = bundles.emplace_back(BundlePass{std::size_t(dealing.owner_of(first)), {}});
    for (; step < g.slices && dealing.bundle_of(view.whole.slice_of(step)) == dealing.bundle_of(first);
         ++step) {
      bundle.layers.push_back(std::size_t(view.whole.layer_of(step)));
      bundle.encoding += machine_.gp.slice + view.whole.slice_seconds(step);
    }
  }
  const TokenTimes times = token_times(machine_, layout, protocol_.slots, shares, costs, bundles);
  const double bytes = view.whole.visible_voxels() * bytes_of_voxel_;
  Prediction p;
  p.gp = times.busiest_gp;
  p.renderer = times.busiest_renderer;
  p.tokens = 3 * costs.hop * double(bundles.size());
  p.shared = hosts.shared_seconds(times.busy_ranks);
  p.seconds = std::max({times.end, p.shared, hosts.link_seconds(bytes)}) * (share ? machine_.sharing : 1);
  return p;
}

std::vector<Prediction> Forecast::predict_all(const std::vector<Layout>& layouts) {
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
    if (k % stride == 0 || layouts[k].placement == Placement::colocated ||
        layouts[k].topology == Topology::mesh)
      try_it(k);
  for (std::size_t step = stride / 2; step > 0; step /= 2)
    for (const std::size_t k : {best - std::min(best, step), std::min(best + step, layouts.size() - 1)})
      try_it(k);
  const auto order = [](const Prediction& p) {
    return std::tuple(p.seconds, p.layout.renderers, p.layout.gps, p.layout.placement, p.layout.topology);
  };
  std::ranges::stable_sort(all, {}, order);
  return all;
}

std::vector<Prediction> Forecast::predict_bundles(const std::vector<Layout>& layouts) {
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

std::string describe(const FrameWork& work) {
  const auto each = [](double seconds, double count) { return count > 0 ? 1e9 * seconds / count : 0.0; };
  return fmt::format(
      "{:.0f} visible voxels of {:.1f} ns on a GP, {:.0f} {} of {:.1f} ns on a Renderer, {:.2f} ms a frame "
      "on each GP",
      work.visible_voxels, each(work.gp, work.visible_voxels), work.items, work.items_name,
      each(work.renderer, work.items), 1e3 * work.frame);
}

std::string to_table(const std::vector<Prediction>& predictions) {
  std::string text = fmt::format("  {:<38}{:>10}{:>10}{:>12}{:>10}{:>10}   limit\n", "ms a frame",
                                 "predicted", "GP", "Renderer", "cores", "tokens");
  for (const Prediction& p : predictions)
    text +=
        fmt::format("  {:<38}{:>10.2f}{:>10.2f}{:>12.2f}{:>10.2f}{:>10.2f}   {}\n", describe(p.layout),
                    1e3 * p.seconds, 1e3 * p.gp, 1e3 * p.renderer, 1e3 * p.shared, 1e3 * p.tokens, p.limit);
  return text;
}

}  // namespace ringsplat::app
