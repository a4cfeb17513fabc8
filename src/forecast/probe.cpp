#include "forecast/probe.hpp"

#include <time.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "base/clock.hpp"
#include "frame/frame_geometry.hpp"
#include "options/method_options.hpp"
#include "ringsplat/base/error.hpp"
#include "session/render_frames.hpp"
#include "simulate/simulation.hpp"
#include "volume/clipped.hpp"
#include "volume/value_statistics.hpp"

namespace ringsplat::app {
namespace {

constexpr std::int64_t most_voxels = std::int64_t{1} << 24;
constexpr int sections_of_large_volumes = 3;
constexpr int repetitions = 3;
constexpr double patience = 2;  ///< seconds after which no measurement is repeated
constexpr int most_renderers = 1024;
/// Number of Renderers that an image is cut for when its regions' costs are measured.
constexpr int probed_renderers = 16;

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

/// Some z slices as a volume of their own, and their place in the whole.
struct Section {
  Grid grid;
  std::vector<std::byte> voxels;
};

Section read_section(VolumeSource& source, int first, int count) {
  Section section{source.grid(), {}};
  section.grid.dims.z = count;
  section.grid.origin += section.grid.direction * glm::dvec3(0, 0, section.grid.spacing.z * first);
  section.voxels.resize(section.grid.bytes());
  source.read_slices(first, count, section.voxels);
  return section;
}

std::vector<Section> read_sections(VolumeSource& source) {
  const Grid& grid = source.grid();
  std::vector<Section> sections;
  if (grid.voxels() <= most_voxels) {
    sections.push_back(read_section(source, 0, grid.dims.z));
    return sections;
  }
  const auto in_slice = std::int64_t(grid.slice_voxels(Axis::z));
  const int wanted = int(std::max<std::int64_t>(1, most_voxels / sections_of_large_volumes / in_slice));
  const int thick = std::min(wanted, std::max(1, grid.dims.z / sections_of_large_volumes));
  const int count = std::min(sections_of_large_volumes, grid.dims.z);
  for (int k = 0; k < count; ++k) {
    const int middle = int((2 * std::int64_t(k) + 1) * grid.dims.z / (2 * count));
    sections.push_back(read_section(source, std::clamp(middle - thick / 2, 0, grid.dims.z - thick), thick));
  }
  return sections;
}

/// Of sections of the volume, whose dimensions are `dims`.
TransferFunction make_for(const std::vector<Section>& sections, glm::ivec3 dims, const VolumeNotes& notes,
                          const TransferFunctionChoice& choice) {
  const Pass pass = [&](const RowVisitor& visit) {
    for (const Section& section : sections) visit(section.voxels, section.grid.dims.x);
  };
  Merging alone;
  const ValueStatistics values =
      describe_values({sections.front().grid.type, notes.fill}, dims, notes, pass, alone);
  if (values.range.empty())
    throw InputError("the volume has no finite value: every voxel is not-a-number or infinite",
                     "check the file's --type and --endian");
  return choice.make(values).function;
}

/// The view as a matrix, so that a part of the volume appears at its place in the whole. A perspective view
/// becomes the orthographic one of the same size, which costs about as much.
Camera fixed_to_world(const Camera& camera, const Grid& grid, int width, int height) {
  if (camera.matrix) return camera;
  const ViewTransform view = make_view(camera, lattice_frame(grid), width, height);
  glm::dmat3 to_lattice = glm::inverse(grid.direction);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) to_lattice[column][row] /= grid.spacing[row];
  const glm::dmat3 linear = view.linear * to_lattice;
  const glm::dvec3 offset = view.offset - linear * grid.origin;
  Camera fixed;
  fixed.matrix.emplace();
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      (*fixed.matrix)[4 * row + column] = linear[int(column)][int(row)];
    (*fixed.matrix)[4 * row + 3] = offset[int(row)];
  }
  return fixed;
}

/// What one view of one section costs: the quickest of several repetitions.
struct ViewCosts {
  double gp = 0, rest = 0, visible_voxels = 0, splats = 0;
  std::vector<double> renderers;
  double busy = std::numeric_limits<double>::infinity();
};

ViewCosts costs_of(const FrameStats& stats, double share) {
  ViewCosts costs;
  const NodeStats sum = stats.total();
  costs.gp = share * sum.computing;
  costs.visible_voxels = double(sum.visible_voxels);
  costs.splats = double(sum.splats_sent);
  costs.busy = costs.gp;
  for (const NodeStats& r : stats.renderers) {
    costs.renderers.push_back(share * (r.drawing + r.compositing + r.delivering));
    costs.busy += costs.renderers.back();
  }
  costs.rest = std::max(0.0, share * stats.seconds - costs.busy);
  return costs;
}

/// What a described machine's nodes spend on the counted work (docs/simulation.md). GPs count passes for all
/// Renderers together; here each Renderer gets a share by its splats.
ViewCosts costs_of(const FrameStats& stats, const Machine& machine, const Grid& grid) {
  ViewCosts costs;
  const NodeStats sum = stats.total();
  const double voxels = double(grid.voxels()), visible = double(sum.visible_voxels);
  costs.gp = double(sum.slices - 1) * machine.gp.slice + encoding_seconds(machine, voxels, visible);
  costs.rest = machine.gp.frame;
  costs.visible_voxels = visible;
  costs.splats = double(sum.splats_sent);
  for (const NodeStats& r : stats.renderers) {
    const double splats = double(r.splats_drawn + r.splats_clipped + r.splats_hidden);
    const double passes = costs.splats > 0 ? double(sum.passes) * splats / costs.splats : 0;
    constexpr double bytes_of_pixel = 16;
    costs.renderers.push_back(
        drawing_seconds(machine, splats, passes, double(r.samples), double(r.payloads_drawn)) +
        double(r.tile_bytes) / bytes_of_pixel * machine.renderer.pixel + machine.renderer.frame);
  }
  costs.busy = 0;  // the first repetition counts
  return costs;
}

/// Renders the frames one after another in this process and measures each, or counts what a described machine
/// would charge.
std::vector<ViewCosts> render_views(const Section& section, const std::vector<FrameSpec>& frames,
                                    const LoadOptions& load, int renderers, const Machine* machine) {
  SoloCollectives solo;
  const Wiring wiring{solo};
  const Layout layout{.gps = 1, .renderers = renderers};
  OpenedVolume volume{section.grid, true, memory_source(section.grid, section.voxels)};
  Scene scene = load_scene(volume, load, layout, wiring);
  std::vector<ViewCosts> costs(frames.size());
  const double until = now_seconds() + patience;
  std::size_t announced = 0;
  const std::size_t rounds = machine == nullptr ? repetitions : 1;
  double cpu = 0, wall = 0;
  const Director director{
      [&]() -> std::optional<FrameSpec> {
        const std::size_t round = announced / frames.size();
        if (round == rounds || (round > 0 && now_seconds() > until)) return std::nullopt;
        cpu = thread_seconds();
        wall = now_seconds();
        return frames[announced++ % frames.size()];
      },
      [&](FrameResult&& result) {
        const double share = std::min(1.0, (thread_seconds() - cpu) / std::max(1e-9, now_seconds() - wall));
        ViewCosts measured = machine == nullptr ? costs_of(result.stats, share)
                                                : costs_of(result.stats, *machine, section.grid);
        ViewCosts& best = costs[(announced - 1) % frames.size()];
        if (measured.busy < best.busy) best = std::move(measured);
      }};
  ProtocolOptions protocol;
  protocol.frames_in_flight = 1;
  EngineOptions engine;
  if (machine != nullptr) simulate({.count_only = true}, engine);
  render_frames(std::move(scene), layout, protocol, director, wiring, engine);
  return costs;
}

/// Adds the Renderers' seconds, scaled to `total` in sum, to the costs of regions; a Renderer's regions get
/// equal shares.
void add_regions(FrameCosts& costs, const FrameGeometry& geometry, const std::vector<double>& renderers,
                 double total) {
  double sum = 0;
  for (const double seconds : renderers) sum += seconds;
  if (sum <= 0) return;
  const RegionOwners owners = geometry.owners(int(renderers.size()));
  std::vector<std::vector<int>> owned;
  for (int k = 0; k < int(renderers.size()); ++k) owned.push_back(geometry.regions.owned(k, owners));
  costs.region.resize(std::max(costs.region.size(), std::size_t(geometry.regions.count())));
  for (std::size_t k = 0; k < owned.size(); ++k)
    for (const int region : owned[k])
      costs.region[std::size_t(region)] += total / sum * renderers[k] / double(owned[k].size());
}

/// The frame cut so finely that its regions' costs tell the load of any number of Renderers. All but splats
/// on the screen are cut into strips by themselves.
FrameSpec cut_finely(FrameSpec frame, const Grid& grid) {
  frame.division.dealt_to = probed_renderers;
  const auto* const splats = std::get_if<Splats>(&frame.how);
  if (splats != nullptr && splats->image_plane == ImagePlane::screen && frame.division.region_size == 0)
    frame.division.region_size = make_geometry(frame, grid).regions.rect(0).width();
  return frame;
}

}  // namespace

TransferFunction function_for(VolumeSource& source, const TransferFunctionChoice& choice) {
  return make_for(read_sections(source), source.grid().dims, source.notes(), choice);
}

std::vector<Camera> probe_views(const std::vector<Camera>& cameras) {
  if (cameras.size() < 12) return {cameras.front()};
  return {cameras.front(), cameras[cameras.size() / 3], cameras[2 * cameras.size() / 3]};
}

FrameCosts measure_frame_costs(VolumeSource& source, FrameSpec frame, const TransferFunctionChoice& choice,
                               const std::vector<Camera>& views, LoadOptions load, const Machine* machine) {
  const Grid grid = source.grid();
  std::vector<Section> sections = read_sections(source);
  frame.shown.transfer_function = make_for(sections, grid.dims, source.notes(), choice);
  check(frame);
  // What is rendered are sections of the clipped part, as volumes of their own.
  const std::optional<VoxelBox> clip = frame.shown.clip;
  if (clip) sections = read_sections(*clipped_source(source, *clip));
  load.clip.reset();
  FrameCosts costs;
  costs.slices = 0;
  costs.items = items_of(frame.how);
  frame.shown.camera = views.front();
  FrameSpec finely = cut_finely(frame, grid);
  frame.division.dealt_to = 1;
  frame.shown.clip.reset();
  std::vector<FrameSpec> whole, cut;
  int regions = 1;
  for (const Camera& camera : views) {
    finely.shown.camera = camera;
    const FrameGeometry geometry = make_geometry(finely, grid);
    costs.slices += double(geometry.slices) / double(views.size());
    regions = std::max(regions, geometry.regions.count());
    costs.columns = geometry.regions.columns();
    frame.shown.camera = finely.shown.camera =
        fixed_to_world(camera, grid, frame.shown.width, frame.shown.height);
    // It may traverse another axis than the perspective view does.
    load.kept_axes[std::size_t(traversed_axis(frame, grid))] = true;
    whole.push_back(frame);
    cut.push_back(finely);
    cut.back().shown.clip.reset();
  }
  int slices_read = 0;
  for (const Section& section : sections) slices_read += section.grid.dims.z;
  const int slices = clip ? clip->dims().z : grid.dims.z;
  const double scale = double(slices) / slices_read / double(views.size());
  const double mean = 1.0 / double(sections.size()) / double(views.size());
  for (const Section& section : sections) {
    const auto together = render_views(section, whole, load, 1, machine);
    const auto apart = render_views(section, cut, load, std::min(regions, most_renderers), machine);
    for (std::size_t k = 0; k < cut.size(); ++k) {
      costs.gp += scale * together[k].gp;
      costs.frame += mean * together[k].rest;
      costs.visible_voxels += scale * together[k].visible_voxels;
      costs.splats += scale * together[k].splats;
      add_regions(costs, make_geometry(cut[k], section.grid), apart[k].renderers,
                  scale * together[k].renderers.front());
    }
  }
  return costs;
}

double measure_hop(Transport& transport) {
  const int ranks = transport.ranks(), rank = transport.rank(), next = (rank + 1) % ranks;
  if (ranks == 1) return 0;
  const int rounds = std::max(8, 2000 / ranks);
  const auto pass_on = [&] {
    transport.send(next, Message({.kind = Kind::token, .source = rank, .destination = next}));
  };
  const double begun = now_seconds();
  if (rank == 0) pass_on();
  for (int taken = 0; taken < rounds;) {
    if (!transport.receive()) {
      transport.wait_next();
      continue;
    }
    transport.note_progress();
    ++taken;
    if (rank != 0 || taken < rounds) pass_on();
  }
  const double hop = (now_seconds() - begun) / rounds / ranks;
  while (!transport.sends_done()) transport.wait_next();
  return hop;
}

RankCosts usual_rank_costs(int ranks, int cores) {
  RankCosts costs;
  costs.cores = cores;
  // Sixteen ranks on two cores take 1.4 to 1.9 times as long as two (docs/performance.md).
  costs.sharing = 1.4;
  if (ranks > cores) costs.hop = 5.4e-6 * ranks / cores;
  return costs;
}

RankCosts described_rank_costs(const Machine& machine, int ranks) {
  const auto& platform = machine.platform;
  constexpr double bytes = 64;  // a header, and what MPI adds
  RankCosts costs;
  costs.cores = platform.hosts > 0 ? platform.hosts * platform.cores : ranks;
  costs.message_software = sending_seconds(machine, bytes) + machine.message.receive;
  costs.hop = costs.message_software + platform.latency + bytes / platform.bandwidth;
  costs.token = machine.gp.token;
  return costs;
}

}  // namespace ringsplat::app
