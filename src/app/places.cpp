#include "app/places.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "app/loading.hpp"
#include "base/archive.hpp"
#include "base/log.hpp"
#include "base/process.hpp"
#include "base/thread_team.hpp"
#include "forecast/forecast.hpp"
#include "net/launcher.hpp"
#include "program/layouts.hpp"

namespace ringsplat::app {

template <class Archive>
void fields(Place& place, Archive& archive) {
  archive(place.machine, place.cores);
}

namespace {

/// A machine's ranks, and the cores that they may use together.
struct Host {
  std::vector<int> ranks;
  std::set<int> cores;
};

std::map<std::string, Host> machines_of(const std::vector<Place>& places) {
  std::map<std::string, Host> machines;
  for (std::size_t rank = 0; rank < places.size(); ++rank) {
    Host& machine = machines[places[rank].machine];
    machine.ranks.push_back(int(rank));
    machine.cores.insert(places[rank].cores.begin(), places[rank].cores.end());
  }
  return machines;
}

}  // namespace

std::vector<Place> places_of_ranks(Collectives& collectives) {
  std::vector<Place> places;
  for (const Block& one : collectives.all_gather(to_bytes(Place{host_name(), allowed_cores()})))
    places.push_back(from_bytes<Place>(one).value());
  return places;
}

int hosts_of(const std::vector<Place>& places) { return int(machines_of(places).size()); }

int shared_cores(const std::vector<Place>& places) {
  std::size_t cores = 0;
  for (const auto& [name, machine] : machines_of(places))
    cores += std::min(machine.ranks.size(), machine.cores.size());
  return int(cores);
}

int ranks_with_cores(const std::vector<Place>& places) {
  return simulated() || machines_of(places).size() > 1 ? int(places.size()) : shared_cores(places);
}

int fair_threads(const std::vector<Place>& places, int rank, int working) {
  const Place& place = places.at(std::size_t(rank));
  const Host machine = machines_of(places).at(place.machine);
  const auto sharing = std::max<std::ptrdiff_t>(
      1, std::count_if(machine.ranks.begin(), machine.ranks.end(), [&](int r) { return r < working; }));
  return std::clamp(int(std::ptrdiff_t(machine.cores.size()) / sharing), 1, int(place.cores.size()));
}

std::string shared_cores_warning(int threads, const std::vector<Place>& places, bool over_mpi) {
  const auto narrowest = std::min_element(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return a.cores.size() < b.cores.size();
  });
  const auto cores = narrowest->cores.size();
  if (cores >= std::size_t(threads)) return {};
  if (!over_mpi)
    return fmt::format(
        "{} threads share the {} core(s) that this process may use; --threads-per-rank {} is as fast",
        threads, cores, cores);
  return fmt::format(
      "the {} threads of rank {} share {} core(s); give it more by mpirun --bind-to none or --map-by "
      "slot:PE={}, or use --threads-per-rank {}",
      threads, narrowest - places.begin(), cores, threads, cores);
}

namespace {

/// The threads of this rank's engine.
void settle_threads(RunOptions& options, const Layout& layout, const std::vector<Place>& places,
                    const Launch& launch) {
  int& threads = options.engine.threads_per_rank;
  if (!options.threads_per_rank) {
    threads = simulated() ? 1
                          : std::min(ThreadTeam::most_threads,
                                     fair_threads(places, launch.rank(), layout.working_ranks()));
    return;
  }
  threads = *options.threads_per_rank;
  check(options.engine);
  const std::string warning =
      threads > 1 ? shared_cores_warning(threads, places, launch.over_mpi()) : std::string();
  if (launch.rank() == 0 && !warning.empty()) log_warning("{}", warning);
}

}  // namespace

SettledRanks settle_ranks(RunOptions& options, Launch& launch) {
  launch.collectives().set_patience({options.protocol.stall_timeout, options.protocol.stall_ends});
  SettledRanks ranks{places_of_ranks(launch.collectives()), {}};
  ranks.layout = choose_layout(options, launch.over_mpi(), launch.ranks(), ranks_with_cores(ranks.places));
  check(options.protocol);
  settle_threads(options, ranks.layout, ranks.places, launch);
  return ranks;
}

namespace {

std::vector<Layout> those_that_fit(std::vector<Layout> layouts, const Grid& grid, const LoadOptions& load) {
  const double machine = machine_memory_bytes();
  const auto too_large = [&](const Layout& layout) {
    return double(predict_memory(grid, load, dealing_of(layout)).predicted.front()) > machine;
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
Machine machine_of(const std::vector<Place>& places, double hop) {
  const int hosts = hosts_of(places), ranks = int(places.size());
  Machine machine = this_machine(hosts, std::max(1, shared_cores(places) / hosts));
  if (!shares_cores(machine, ranks) && ranks > 1) machine.platform.latency = hop;
  return machine;
}

}  // namespace

Layout choose_roles(const RenderOptions& o, const std::vector<Camera>& cameras, const Grid& grid,
                    const LoadOptions& load, const std::vector<Place>& places, Launch& launch) {
  const auto& described = o.run.simulation.machine;
  const int ranks = launch.ranks();
  auto layouts =
      layouts_to_choose_from(o.run, launch.over_mpi(), ranks,
                             described ? ranks_with_own_cores(*described, ranks) : ranks_with_cores(places));
  if (!described) layouts = those_that_fit(std::move(layouts), grid, load);
  const double hop = described ? 0 : measure_hop(*launch.transport());
  Layout chosen;
  launch.check_on_rank_0([&] {
    const auto source = open_volume(o.volume);
    const Machine machine = described ? *described : machine_of(places, hop);
    Forecast forecast(*source, o.frame, TransferFunctionChoice(o.transfer_function, o.colour),
                      some_views(cameras.empty() ? std::vector{o.frame.shown.camera} : cameras), machine,
                      o.run.simulation.voxel_weight, ranks, o.run.protocol);
    const auto predictions =
        o.run.bundle || !described ? forecast.predict_all(layouts) : forecast.predict_bundles(layouts);
    chosen = predictions.front().layout;
    say_choice(predictions);
  });
  return launch.of_rank_0(chosen);
}

int drawing_renderers(const Layout& layout, const std::vector<Place>& places, const Launch& launch) {
  // Dedicated Renderers have no other work; a simulated machine's cores are not this machine's.
  if (layout.placement != Placement::colocated || !launch.over_mpi() || simulated()) return layout.renderers;
  const int cores = shared_cores(places);
  return cores < layout.working_ranks() ? std::min(2 * cores, layout.renderers) : layout.renderers;
}

}  // namespace ringsplat::app
