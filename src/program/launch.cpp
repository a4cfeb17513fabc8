#include "program/launch.hpp"

#include "base/lack_of_memory.hpp"
#include "net/launcher.hpp"
#include "program/layouts.hpp"

namespace ringsplat::app {

std::string build_id() {
  return fmt::format("ringsplat {} with wire format {}", RINGSPLAT_VERSION, wire_format());
}

Outcome guarded(const std::function<ExitCode()>& work) {
  try {
    return {work(), {}};
  } catch (const InputError& e) {
    return {e.exit_code(), detail::one_line(e.what())};
  } catch (const Error& e) {
    return {e.exit_code(), e.what()};
  } catch (const std::exception& e) {
    if (is_lack_of_memory(e)) return {ExitCode::run_failed, lack_of_memory};
    return {ExitCode::run_failed,
            fmt::format("{}; hint: this should not happen, please report it", e.what())};
  }
}

Launch::Launch(int& argc, char**& argv, TransportChoice choice)
    : in_one_process_(choice == TransportChoice::loopback) {
  const bool launched = MpiSession::launched();
  if (launched || choice == TransportChoice::mpi) session_.emplace(argc, argv);
  if (session_)
    collectives_ = session_->make_collectives();
  else
    collectives_ = std::make_unique<SoloCollectives>();
}

void Launch::require_same_build() const {
  if (!session_) return;
  const auto builds = session_->introductions(build_id());
  for (std::size_t rank = 1; rank < builds.size(); ++rank)
    if (builds[rank] != builds.front())
      throw InputError(
          fmt::format("rank {} runs another build: {}, rank 0 runs {}", rank, builds[rank], builds.front()),
          "install the same build on all machines, and see that no other comes first in a PATH");
}

void Launch::take_leave() {
  if (simulated() || !collectives_->patience.ends) return;
  const auto watched = collectives_->watched("silent after the last frame, of which all is written,", false);
  std::uint64_t nothing = 0;
  collectives_->sum({&nothing, 1});
}

namespace {

/// The layout without its numbers of nodes.
Layout empty_layout(const RunOptions& o) {
  Layout layout{.placement = o.placement.value_or(Placement::dedicated),
                .topology = o.topology,
                .bundle = o.bundle.value_or(1)};
  if (o.mesh) {
    layout.mesh_columns = o.mesh->x;
    layout.mesh_rows = o.mesh->y;
    layout.routing = o.routing;
  }
  return layout;
}

/// Nodes left for the other role when one role has `given`.
int the_rest(int given, int ranks, Placement placement) {
  return placement == Placement::dedicated ? std::max(1, ranks - given) : ranks;
}

Layout layout_on_ranks(const RunOptions& o, int ranks, int cores) {
  const bool no_count = !o.gps && !o.renderers;
  Layout layout = empty_layout(o);
  if (no_count && o.placement == Placement::dedicated) {
    layout.renderers = std::max(1, ranks / 3);
    layout.gps = std::max(1, ranks - layout.renderers);
  } else if (no_count) {
    layout.gps = layout.renderers = cores > 0 && !o.placement ? std::min(ranks, cores) : ranks;
    layout.placement = Placement::colocated;
    layout.idle = ranks - layout.gps;
  } else {
    layout.gps = o.gps ? *o.gps : the_rest(*o.renderers, ranks, layout.placement);
    layout.renderers = o.renderers ? *o.renderers : the_rest(*o.gps, ranks, layout.placement);
  }
  return layout;
}

}  // namespace

std::vector<Layout> layouts_to_choose_from(const RunOptions& o, bool over_mpi, int ranks, int cores) {
  if (o.choose_bundle && !o.simulation.machine)
    throw InputError("--bundle auto follows from a described machine's costs, but these ranks are real",
                     "give a number, or leave it out: slices are then dealt one by one");
  if (!over_mpi)
    throw InputError("--gps auto and --renderers auto give ranks their roles, but this is one process",
                     "start it with mpirun -n N; ringsplat info VOLUME --ranks N predicts without it");
  if (simulated() && !o.simulation.machine)
    throw InputError(
        "--gps auto and --renderers auto measure frames by this machine's clock, not the simulated one",
        "name the machine that is simulated with --machine, whose costs then decide, or give both numbers");
  if (o.topology == Topology::mesh)
    throw InputError("--renderers auto has no effect in a mesh, whose shape says which ranks draw",
                     "leave it out; ringsplat info VOLUME --ranks N predicts meshes too");
  auto layouts =
      in_bundles(possible_layouts(ranks, false, o.gps || o.renderers ? 0 : cores), o.bundle.value_or(1));
  std::erase_if(layouts, [&](const Layout& l) {
    return l.gps != o.gps.value_or(l.gps) || l.renderers != o.renderers.value_or(l.renderers) ||
           l.placement != o.placement.value_or(l.placement);
  });
  if (layouts.empty())
    throw InputError(fmt::format("{} ranks cannot be given such roles", ranks),
                     "use --gps auto alone, or give both numbers");
  return layouts;
}

Layout choose_layout(const RunOptions& options, bool over_mpi, int ranks, int cores) {
  constexpr int most_in_one_process = 4096;
  RunOptions o = options;
  if (o.mesh) {  // unless told otherwise each row has a Renderer at its left end
    o.gps = o.mesh->x * o.mesh->y;
    o.renderers = o.renderers.value_or(o.mesh->y);
  }
  // Check counts below 1 first: their own message is clearer than that of a wrong sum.
  check(Layout{.gps = o.gps.value_or(1), .renderers = o.renderers.value_or(1)});
  if (std::max(o.gps.value_or(1), o.renderers.value_or(1)) > 1 << 24)
    throw InputError("--gps or --renderers is far more than any machine has", "use one rank for each core");
  if (o.choose_roles) static_cast<void>(layouts_to_choose_from(o, over_mpi, ranks));
  if (!over_mpi) {
    if (ranks > 1)
      throw InputError(
          fmt::format("--transport loopback runs in one process, but the launcher started {}", ranks),
          "leave out mpirun, or the option");
    Layout layout = empty_layout(o);
    layout.gps = o.gps.value_or(1);
    layout.renderers = o.renderers.value_or(1);
    check(layout);
    if (layout.ranks() > most_in_one_process)
      throw InputError(
          fmt::format("{} ranks are too many for one process", layout.ranks()),
          fmt::format("start it with mpirun, or use at most {} GPs and Renderers", most_in_one_process));
    return layout;
  }
  if (o.choose_roles) return layouts_to_choose_from(o, over_mpi, ranks).front();
  const Layout layout = layout_on_ranks(o, ranks, cores);
  check(layout);
  if (layout.ranks() != ranks)
    throw InputError(
        fmt::format("{} GP(s) and {} Renderer(s) on {} ranks need {}, but the job has {}", layout.gps,
                    layout.renderers, layout.placement == Placement::dedicated ? "dedicated" : "colocated",
                    layout.ranks(), ranks),
        fmt::format("start it with mpirun -n {}, or change {}{}", layout.ranks(),
                    o.topology == Topology::mesh ? "--mesh and --renderers" : "--gps and --renderers",
                    std::max(layout.gps, layout.renderers) == ranks && o.topology == Topology::ring
                        ? ", or add --roles colocated"
                        : ""));
  return layout;
}

}  // namespace ringsplat::app
