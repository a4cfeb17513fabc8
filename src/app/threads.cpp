#include "app/threads.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/log.hpp"
#include "base/process.hpp"
#include "net/blocks.hpp"

namespace ringsplat::app {
namespace {

std::vector<int> cores_by_rank(Launch& launch) {
  const int mine = allowed_cores();
  std::vector<int> cores;
  for (const Block& one : launch.collectives().all_gather(block_of_value(mine)))
    cores.push_back(value_of<int>(one, "how many cores it has"));
  return cores;
}

}  // namespace

std::string shared_cores_warning(int threads, const std::vector<int>& cores, bool over_mpi) {
  const auto narrowest = std::min_element(cores.begin(), cores.end());
  if (narrowest == cores.end() || *narrowest >= threads) return {};
  if (!over_mpi)
    return fmt::format(
        "{} threads share the {} core(s) that this process may use; --threads-per-rank {} is as fast",
        threads, *narrowest, *narrowest);
  return fmt::format(
      "the {} threads of rank {} share {} core(s); give it more by mpirun --bind-to none or --map-by "
      "slot:PE={}, or use --threads-per-rank {}",
      threads, narrowest - cores.begin(), *narrowest, threads, *narrowest);
}

void warn_of_shared_cores(int threads, Launch& launch) {
  if (threads == 1) return;
  const std::string warning = shared_cores_warning(threads, cores_by_rank(launch), launch.over_mpi());
  if (launch.rank() == 0 && !warning.empty()) log_warning("{}", warning);
}

}  // namespace ringsplat::app
