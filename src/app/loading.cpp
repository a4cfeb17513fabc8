#include "app/render_job.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/archive.hpp"
#include "base/log.hpp"
#include "base/printable.hpp"
#include "base/process.hpp"
#include "base/thread_team.hpp"
#include "forecast/forecast.hpp"
#include "net/launcher.hpp"
#include "program/layouts.hpp"
#include "record/trace.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {

void fields(Binding& binding, auto& archive) { archive(binding.machine, binding.cores); }

namespace {

/// A machine's ranks, and the cores that they may use together.
struct Host {
  std::vector<int> ranks;
  std::set<int> cores;
};

std::map<std::string, Host> machines_of(const std::vector<Binding>& bindings) {
  std::map<std::string, Host> machines;
  for (std::size_t rank = 0; rank < bindings.size(); ++rank) {
    Host& machine = machines[bindings[rank].machine];
    machine.ranks.push_back(int(rank));
    machine.cores.insert(bindings[rank].cores.begin(), bindings[rank].cores.end());
  }
  return machines;
}

/// The threads of this rank's engine.
void settle_threads(Job& job, const Launch& launch) {
  RunOptions& run = job.options.run;
  int& threads = run.engine.threads_per_rank;
  if (!run.threads_per_rank) {
    threads = simulated() ? 1
                          : std::min(ThreadTeam::most_threads,
                                     fair_threads(job.bindings, launch.rank(), job.layout.working_ranks()));
    return;
  }
  threads = *run.threads_per_rank;
  check(run.engine);
  const std::string warning =
      threads > 1 ? shared_cores_warning(threads, job.bindings, launch.over_mpi()) : std::string();
  if (launch.rank() == 0 && !warning.empty()) log_warning("{}", warning);
}

}  // namespace

int shared_cores(const std::vector<Binding>& bindings) {
  std::size_t cores = 0;
  for (const auto& [name, machine] : machines_of(bindings))
    cores += std::min(machine.ranks.size(), machine.cores.size());
  return int(cores);
}

int ranks_with_cores(const std::vector<Binding>& bindings) {
  return simulated() || machines_of(bindings).size() > 1 ? int(bindings.size()) : shared_cores(bindings);
}

int fair_threads(const std::vector<Binding>& bindings, int rank, int working) {
  const Binding& binding = bindings.at(std::size_t(rank));
  const Host machine = machines_of(bindings).at(binding.machine);
  const auto sharing = std::max<std::ptrdiff_t>(
      1, std::count_if(machine.ranks.begin(), machine.ranks.end(), [&](int r) { return r < working; }));
  return std::clamp(int(std::ptrdiff_t(machine.cores.size()) / sharing), 1, int(binding.cores.size()));
}

std::string shared_cores_warning(int threads, const std::vector<Binding>& bindings, bool over_mpi) {
  const auto narrowest =
      std::ranges::min_element(bindings, {}, [](const Binding& binding) { return binding.cores.size(); });
  const auto cores = narrowest->cores.size();
  if (cores >= std::size_t(threads)) return {};
  if (!over_mpi)
    return fmt::format(
        "{} threads share the {} core(s) that this process may use; --threads-per-rank {} is as fast",
        threads, cores, cores);
  return fmt::format(
      "the {} threads of rank {} share {} core(s); give it more by mpirun --bind-to none or --map-by "
      "slot:PE={}, or use --threads-per-rank {}",
      threads, narrowest - bindings.begin(), cores, threads, cores);
}

void settle_ranks(Job& job, Launch& launch) {
  const RunOptions& run = job.options.run;
  launch.collectives().patience = {run.protocol.stall_timeout, run.protocol.stall_ends};
  for (const Block& one : launch.collectives().all_gather(to_bytes(Binding{host_name(), allowed_cores()})))
    job.bindings.push_back(from_bytes<Binding>(one).value());
  job.layout = choose_layout(run, launch.over_mpi(), launch.ranks(), ranks_with_cores(job.bindings));
  check(run.protocol);
  settle_threads(job, launch);
}

OpenedVolume open(const VolumeOptions& volume, Launch& launch) {
  const auto watched = launch.collectives().watched(fmt::format("opening {}", volume.path));
  return open_everywhere(
      launch.collectives(), [&] { return open_volume(volume); }, volume.path);
}

TransferFunction stand_in_function() {
  return {
      .name = "ramp", .colours = {{0, glm::dvec3(0.0)}, {1, glm::dvec3(1.0)}}, .opacities = {{0, 0}, {1, 1}}};
}

namespace {

/// Of slices, by GP.
std::vector<std::uint64_t> predicted_bytes(const Grid& grid, const LoadOptions& load, SliceDealing dealing) {
  std::vector<std::uint64_t> bytes(std::size_t(dealing.gps), 0);
  for (const int factor : load.factors) {
    const Grid level = reduced_grid(grid, {factor, load.prefilter});
    for (int gp = 0; gp < dealing.gps; ++gp)
      bytes[std::size_t(gp)] +=
          SliceStore::bytes_needed(level, gp, dealing, load.kept_axes, load.with_normals);
  }
  return bytes;
}

std::vector<Layout> those_that_fit(std::vector<Layout> layouts, const Grid& grid, const LoadOptions& load) {
  const double machine = machine_memory_bytes();
  const auto too_large = [&](const Layout& layout) {
    return double(predicted_bytes(grid, load, dealing_of(layout)).front()) > machine;
  };
  std::vector<Layout> fitting = layouts;
  std::erase_if(fitting, too_large);
  // When none fits, the later check of the chosen layout's memory reports it.
  return fitting.empty() ? layouts : fitting;
}

void say_choice(const std::vector<Prediction>& predictions) {
  const Prediction& best = predictions.front();
  std::string others;
  if (predictions.size() > 1)
    others = fmt::format("; next {} with {:.2f} ms, last {} with {:.2f} ms", describe(predictions[1].layout),
                         1e3 * predictions[1].seconds, describe(predictions.back().layout),
                         1e3 * predictions.back().seconds);
  log_info("chose {}: {:.2f} ms a frame predicted, limited by {}{}", describe(best.layout),
           1e3 * best.seconds, best.limit, others);
}

/// What the real ranks run on. A hop says little of a machine where ranks wait for cores.
Machine machine_of(const std::vector<Binding>& bindings, double hop) {
  const int hosts = int(machines_of(bindings).size()), ranks = int(bindings.size());
  Machine machine = this_machine(hosts, std::max(1, shared_cores(bindings) / hosts));
  if (!shares_cores(machine, ranks) && ranks > 1) machine.platform.latency = hop;
  return machine;
}

/// The layout for --gps auto and --renderers auto: the one in which frames of the job's views are foreseen to
/// take least, on the described machine or on this one. All ranks measure what a message costs; rank 0 prints
/// its choice on stderr. Layouts whose GPs cannot hold their slices are left out. Without views the options'
/// own counts. All ranks call it before the volume is loaded; all throw the same InputError.
Layout choose_roles(const Job& job, Launch& launch) {
  const RenderOptions& o = job.options;
  const auto& described = o.run.simulation.machine;
  const int ranks = launch.ranks();
  auto layouts = layouts_to_choose_from(
      o.run, launch.over_mpi(), ranks,
      described ? ranks_with_own_cores(*described, ranks) : ranks_with_cores(job.bindings));
  if (!described) layouts = those_that_fit(std::move(layouts), job.volume.grid, job.load);
  const double hop = described ? 0 : measure_hop(*launch.transport());
  Layout chosen;
  launch.check_on_rank_0([&] {
    const auto source = open_volume(o.volume);
    const Machine machine = described ? *described : machine_of(job.bindings, hop);
    Forecast forecast(*source, o.frame, *job.transfer_function,
                      some_views(job.cameras.empty() ? std::vector{o.frame.shown.camera} : job.cameras),
                      machine, o.run.simulation.voxel_weight, ranks, o.run.protocol);
    const auto predictions =
        o.run.bundle || !described ? forecast.predict_all(layouts) : forecast.predict_bundles(layouts);
    chosen = predictions.front().layout;
    say_choice(predictions);
  });
  return launch.of_rank_0(chosen);
}

/// How many Renderers get regions: all, but two for each core when colocated ranks share cores. More would
/// not draw faster, and each one's token passes all slices.
int drawing_renderers(const Job& job, const Launch& launch) {
  const Layout& layout = job.layout;
  // Dedicated Renderers have no other work; a simulated machine's cores are not this machine's.
  if (layout.placement != Placement::colocated || !launch.over_mpi() || simulated()) return layout.renderers;
  const int cores = shared_cores(job.bindings);
  return cores < layout.working_ranks() ? std::min(2 * cores, layout.renderers) : layout.renderers;
}

/// Of the GPs in this process, or in all of this machine.
double slice_bytes_here(const Job& job, const Launch& launch, bool in_machine) {
  const auto is_here = [&](int rank) {
    if (!launch.over_mpi() || rank == launch.rank()) return true;
    return in_machine &&
           job.bindings[std::size_t(rank)].machine == job.bindings[std::size_t(launch.rank())].machine;
  };
  double held = 0;
  for (int gp = 0; gp < job.layout.gps; ++gp)
    if (is_here(job.layout.rank_of({Role::gp, gp}))) held += double(job.slice_bytes[std::size_t(gp)]);
  return held;
}

double picture_bytes_here(const Job& job, std::size_t pictures, const Launch& launch) {
  const Shown& shown = job.options.frame.shown;
  return launch.rank() == 0 ? 4.0 * sizeof(float) * shown.width * shown.height * double(pictures) : 0;
}

void log_roles(const Job& job, const Launch& launch) {
  std::string axes;
  for (const Axis axis : all_axes)
    if (job.load.kept_axes[std::size_t(axis)]) axes += name(axis);
  for (int rank = 0; rank < job.layout.ranks(); ++rank) {
    if (launch.over_mpi() && rank != launch.rank()) continue;
    for (const NodeId node : job.layout.nodes_on(rank))
      if (node.role == Role::gp)
        log_debug("{} keeps slices of axes {}: {:.1f} MiB", to_string(node), axes,
                  double(job.slice_bytes[std::size_t(node.index)]) / (1 << 20));
      else
        log_debug("{} is here", to_string(node));
  }
}

}  // namespace

void check_memory(const Job& job, std::size_t pictures, const Launch& launch, double volumes) {
  const double machine = machine_memory_bytes(), held = slice_bytes_here(job, launch, true) * volumes,
               frames = picture_bytes_here(job, pictures, launch);
  if (held + frames <= machine) return;
  throw InputError(
      fmt::format("{} {:.1f} GiB for slices and {:.1f} GiB for pictures on one machine, which has "
                  "{:.1f} GiB",
                  volumes > 1 ? "two volumes at once need" : "this needs", held / (1 << 30),
                  frames / (1 << 30), machine / (1 << 30)),
      volumes > 1     ? "compare on more machines, or look at one volume"
      : held > frames ? "use ranks on more machines"
                      : "use a smaller --size");
}

std::size_t room_to_read_ahead(const Job& job, std::size_t pictures, const Launch& launch) {
  const double needed = 2 * slice_bytes_here(job, launch, true) + picture_bytes_here(job, pictures, launch);
  return needed <= machine_memory_bytes() ? std::size_t(slice_bytes_here(job, launch, false)) : 0;
}

void settle_layout(Job& job, std::size_t pictures, std::size_t volumes, Launch& launch) {
  if (job.options.run.choose_roles) job.layout = choose_roles(job, launch);
  job.options.frame.division.dealt_to = drawing_renderers(job, launch);
  const SliceDealing dealing = dealing_of(job.layout);
  job.slice_bytes = predicted_bytes(job.volume.grid, job.load, dealing);
  if (job.volume.has_labels) {
    Grid labels = job.volume.grid;
    labels.type = ScalarType::uint8;
    LoadOptions load = job.load;
    load.with_normals = false;
    std::ranges::transform(job.slice_bytes, predicted_bytes(labels, load, dealing), job.slice_bytes.begin(),
                           std::plus());
  }
  for (std::uint64_t& bytes : job.slice_bytes) bytes *= volumes;
  launch.check_on_all_ranks([&] { check_memory(job, pictures, launch); });
  log_roles(job, launch);
}

Scene load(const Job& job, OpenedVolume& volume, Progress& progress, Launch& launch) {
  const PlainFloats as_before_the_first_frame;
  const auto watched = launch.collectives().watched(fmt::format("reading {}", volume.name));
  progress.begin("loading", 1);
  LoadOptions told = job.load;
  told.told = [&](double part, bool in_step) {
    // Memory for the slices comes before, at no pace that tells of the rest.
    if (part == 0) progress.begin("loading", 1);
    progress.at(part);
    if (in_step && job.load.told) job.load.told(part, true);
  };
  Scene scene = load_scene(volume, told, job.layout, launch.wiring(job.options.run.poll));
  progress.end();
  volume.source.reset();
  const auto& mask = job.options.volume.mask.path;
  check_values(scene.values, mask.empty() ? "check the file's --type and --endian"
                                          : fmt::format("look what {} covers of it", printable(mask)));
  return scene;
}

void render_all(const Job& job, const ProtocolOptions& protocol, Scene scene, Director director,
                Launch& launch) {
  const RunOptions& run = job.options.run;
  try {
    if (protocol.trace) protocol.trace->compare_clocks(launch.collectives());
    render_frames(std::move(scene), job.layout, protocol, std::move(director), launch.wiring(run.poll),
                  run.engine);
  } catch (const InputError& e) {
    throw RunError(e.what());
  }
}

}  // namespace ringsplat::app
