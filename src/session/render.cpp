#include "session/render.hpp"

#include <nlohmann/json.hpp>

#include "base/process.hpp"
#include "base/thread_team.hpp"
#include "frame/frame_geometry.hpp"
#include "frame/frame_spec_bytes.hpp"
#include "net/agree.hpp"
#include "protocol/bundle_engine.hpp"
#include "protocol/rank.hpp"
#include "ringsplat/frame/frame_spec.hpp"
#include "session/directed_frames.hpp"
#include "session/render_frames.hpp"
#include "sheet_engine/scalar_planes.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "sheet_engine/sheet_frame.hpp"
#include "sheet_engine/sheet_rays.hpp"
#include "splat_engine/splat_engine.hpp"

namespace ringsplat {
namespace {

/// What ranks must agree on to understand each other's messages while a volume is dealt and rendered.
Facts facts_of(const Grid& grid, const LoadOptions& load, const Layout& layout) {
  std::string axes, levels;
  for (const Axis axis : all_axes)
    if (load.kept_axes[std::size_t(axis)]) axes += name(axis);
  for (const int factor : load.factors) levels += fmt::format("{} ", factor);
  Facts facts = facts_of(grid);
  const Facts more{{"wire format", wire_format()},
                   {"kept axes", axes},
                   {"normals", load.with_normals ? "kept" : "left out"},
                   {"levels", levels},
                   {"prefilter", load.prefilter ? "yes" : "no"},
                   {"clip box", load.clip ? text_of(*load.clip) : "none"}};
  facts.insert(facts.end(), more.begin(), more.end());
  const auto roles = to_json(layout);
  for (const auto& [what, value] : roles.items()) facts.push_back({what, value.dump()});
  return facts;
}

/// Makes the engine of a rank, which gets its slices of the scene and its others.
std::unique_ptr<Engine> make_engine(Scene& scene, int rank, const Layout& layout,
                                    const EngineOptions& options, TakePicture take) {
  // Empty on a rank without a GP.
  const auto slices_of = [rank](Scene& held) {
    return std::make_shared<const SliceStore>(std::move(held.stores[rank]));
  };
  const auto kept =
      options.keep ? std::uint64_t(*options.keep) << 20 : usual_kept_bytes(scene.grid, layout.gps);
  EngineSetup setup{.grid = scene.grid,
                    .gps = layout.gps,
                    .renderers = layout.renderers,
                    .bundle = layout.bundle,
                    .colocated = layout.placement == Placement::colocated,
                    .sketch = scene.sketch,
                    .slices = slices_of(scene),
                    .threads = options.threads_per_rank,
                    .kept_bytes = kept / (1 + scene.others.size()),
                    // A mesh needs all slices: payloads do not meet because tokens visit the GPs in order
                    // (docs/protocol.md).
                    .skip_empty = !layout.routed(),
                    .take = std::move(take)};
  if (options.encodes_pictures)
    for (WorkCosts* costs : {&setup.splat_costs, &setup.sheet_costs}) costs->picture += encoding_a_pixel;
  for (Scene& other : scene.others) setup.others.push_back({other.sketch, slices_of(other)});
  return options.engine ? options.engine(std::move(setup)) : make_rank_engine(std::move(setup));
}

class Engines final : public Engine {
 public:
  Engines(EngineSetup setup, std::vector<MakeEngine> methods)
      : setup_(std::move(setup)), methods_(std::move(methods)), engines_(methods_.size()) {}

  FramePlan plan(const Announcement& a) override { return engine_of(a).plan(a); }
  std::unique_ptr<Encoder> encoder(int gp, const Announcement& a) override {
    return engine_of(a).encoder(gp, a);
  }
  std::shared_ptr<Painter> painter(int renderer, const Announcement& a) override {
    return engine_of(a).painter(renderer, a);
  }
  std::unique_ptr<Canvas> canvas(const Announcement& a) override { return engine_of(a).canvas(a); }

 private:
  Engine& engine_of(const Announcement& a) {
    const std::size_t method = method_of(a.body).index();
    std::unique_ptr<Engine>& engine = engines_[method];
    if (!engine) engine = methods_[method](setup_);
    return *engine;
  }

  EngineSetup setup_;
  std::vector<MakeEngine> methods_;  ///< in the order of Method's alternatives
  std::vector<std::unique_ptr<Engine>> engines_;
};

}  // namespace

std::string wire_format() { return RINGSPLAT_WIRE_FORMAT; }

void check_frame(const FrameSpec& spec, const Grid& grid) {
  check(spec);
  if (std::holds_alternative<Sheets>(spec.how))
    static_cast<void>(make_sheet_rays(*make_sheet_frame(spec, grid, 1, 1)));
  else
    static_cast<void>(make_geometry(spec, grid));
}

Sharing sharing_of(const Layout& layout, const Wiring& wiring) {
  Sharing sharing{dealing_of(layout), {}, wiring.collectives};
  for (int gp = 0; gp < layout.gps; ++gp)
    sharing.process_of_gp.push_back(wiring.transport != nullptr ? layout.rank_of({Role::gp, gp}) : 0);
  return sharing;
}

void check_wiring(const Layout& layout, const Wiring& wiring) {
  check(layout);
  if (wiring.transport == nullptr || wiring.transport->ranks() == layout.ranks()) return;
  throw InputError(
      fmt::format("{} GP(s) and {} Renderer(s) need {} ranks, but the job has {}", layout.gps,
                  layout.renderers, layout.ranks(), wiring.transport->ranks()),
      fmt::format("start it with mpirun -n {}, or change --gps and --renderers", layout.ranks()));
}

void require_same_scene(const Grid& grid, const LoadOptions& options, const Layout& layout,
                        const Wiring& wiring) {
  require_same(wiring.collectives, facts_of(grid, options, layout), "was given another scene to load",
               "every process must pass the same grid, options and layout, and run the same build");
}

std::array<bool, 3> needed_axes(FrameSpec frame, const std::vector<Camera>& cameras, const Grid& grid) {
  std::array<bool, 3> needed{};
  for (const Camera& camera : cameras) {
    frame.shown.camera = camera;
    needed[std::size_t(traversed_axis(frame, grid))] = true;
  }
  return needed;
}

LoadOptions needed_along(const FrameSpec& spec, const std::array<bool, 3>& axes) {
  const bool sheets = std::holds_alternative<Sheets>(spec.how);
  return {.kept_axes = axes,
          .with_normals = !sheets && spec.shown.shading == Shading::phong,
          .factors = {spec.shown.reduction.factor},
          .prefilter = spec.shown.reduction.prefilter,
          .with_cell_ranges = sheets,
          .clip = spec.shown.clip};
}

LoadOptions needed_to_render(const FrameSpec& spec, const Grid& grid) {
  return needed_along(spec, needed_axes(spec, {spec.shown.camera}, grid));
}

Scene load_scene(OpenedVolume& volume, const LoadOptions& options, const Layout& layout,
                 const Wiring& wiring) {
  require_same_scene(volume.grid, options, layout, wiring);
  check_wiring(layout, wiring);
  return deal_scene(volume, options, sharing_of(layout, wiring));
}

std::uint64_t usual_kept_bytes(const Grid& grid, int gps) {
  constexpr std::uint64_t mib = 1 << 20, in_all = 2048 * mib, at_least = 256 * mib;
  std::uint64_t all_planes = 0;
  for (const Axis axis : all_axes)
    all_planes += plane_bytes(grid.slice_width(axis), grid.slice_height(axis), {.floats = true}) *
                  std::uint64_t(grid.dims[static_cast<int>(axis)]);
  const std::uint64_t share = std::max(in_all, 3 * std::uint64_t(grid.bytes()) / 4) / std::uint64_t(gps);
  return std::min(all_planes, std::max(at_least, share));
}

void check(const EngineOptions& options) {
  if (options.threads_per_rank < 1)
    throw InputError(fmt::format("--threads-per-rank is {}", options.threads_per_rank),
                     "it must be at least 1");
  if (options.threads_per_rank > ThreadTeam::most_threads)
    throw InputError(
        fmt::format("--threads-per-rank is {}, more than a rank can use", options.threads_per_rank),
        fmt::format("use one for each core of a rank, at most {}", ThreadTeam::most_threads));
}

void render_frames(Scene scene, const Layout& layout, const ProtocolOptions& protocol, Director director,
                   const Wiring& wiring, const EngineOptions& options) {
  check_wiring(layout, wiring);
  check(protocol);
  check(options);
  flush_denormals();
  DirectedFrames frames(std::move(director), scene.grid, layout);
  const auto engine_of = [&](int rank) {
    return make_engine(scene, rank, layout, options, [&frames](std::int64_t frame, Image&& picture) {
      frames.take_picture(frame, std::move(picture));
    });
  };
  if (wiring.transport == nullptr) return run_loopback(layout, protocol, engine_of, frames, wiring.loopback);
  const auto engine = engine_of(wiring.transport->rank());
  const auto network = options.network ? options.network(*wiring.transport) : nullptr;
  Transport& transport = network ? *network : *wiring.transport;
  Host(layout, protocol, transport, *engine, &frames).run();
}

std::unique_ptr<Engine> make_engines(EngineSetup setup, std::vector<MakeEngine> methods) {
  const int bundle = setup.bundle;
  std::unique_ptr<Engine> engine = std::make_unique<Engines>(std::move(setup), std::move(methods));
  return bundle > 1 ? make_bundle_engine(std::move(engine), bundle) : std::move(engine);
}

std::unique_ptr<Engine> make_rank_engine(EngineSetup setup) {
  return make_engines(std::move(setup), {maker_of<SplatEngine>(), maker_of<SheetEngine>()});
}

}  // namespace ringsplat
