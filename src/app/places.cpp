#include "app/places.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <sstream>

#include "base/log.hpp"
#include "base/process.hpp"
#include "base/thread_team.hpp"
#include "net/blocks.hpp"
#include "net/launcher.hpp"

namespace ringsplat::app {
namespace {

/// A machine's ranks, and the cores that they may use together.
struct Machine {
  std::vector<int> ranks;
  std::set<int> cores;
};

std::map<std::string, Machine> machines_of(const std::vector<Place>& places) {
  std::map<std::string, Machine> machines;
  for (std::size_t rank = 0; rank < places.size(); ++rank) {
    Machine& machine = machines[places[rank].machine];
    machine.ranks.push_back(int(rank));
    machine.cores.insert(places[rank].cores.begin(), places[rank].cores.end());
  }
  return machines;
}

}  // namespace

std::vector<Place> places_of_ranks(Collectives& collectives) {
  std::string mine = fmt::format("host:{}", host_name());
  for (const int core : allowed_cores()) mine += fmt::format(" {}", core);
  std::vector<Place> places;
  for (const Block& one : collectives.all_gather(block_of(std::as_bytes(std::span(mine))))) {
    std::istringstream words({reinterpret_cast<const char*>(one.data()), one.size()});
    Place& place = places.emplace_back();
    words >> place.machine;
    for (int core = 0; words >> core;) place.cores.push_back(core);
  }
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
  const Machine machine = machines_of(places).at(place.machine);
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

}  // namespace ringsplat::app
