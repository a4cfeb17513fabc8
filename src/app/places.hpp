#pragma once
#include <string>
#include <vector>

#include "options/options.hpp"
#include "program/launch.hpp"
#include "scene/scene.hpp"

/// Where a job's ranks run, and what follows from it.
namespace ringsplat::app {

struct Place {
  std::string machine;
  std::vector<int> cores;  ///< that the rank may use
};

/// By rank. Collective.
std::vector<Place> places_of_ranks(Collectives& collectives);

/// How many machines the ranks run on.
int hosts_of(const std::vector<Place>& places);

/// Cores of all machines that the ranks share; a machine counts at most one a rank.
int shared_cores(const std::vector<Place>& places);

/// How many ranks may work when no option says it: one for each core. On several machines, and simulated
/// ones, all: the last ranks could be all of one machine's.
int ranks_with_cores(const std::vector<Place>& places);

/// The threads that this rank takes when no option says it: its machine's cores, shared evenly by those of
/// the first `working` ranks that run there, but no more than it may use; at least 1.
int fair_threads(const std::vector<Place>& places, int rank, int working);

/// Where the ranks run, and the nodes they are.
struct SettledRanks {
  std::vector<Place> places;
  Layout layout;
};

/// Chooses the layout, the patience with slow ranks and the threads of this rank's engine. Warns on rank 0
/// when threads that were asked for have to share cores. Collective; throws InputError on all ranks.
SettledRanks settle_ranks(RunOptions& options, Launch& launch);

/// The warning when ranks of `threads` threads have too few cores; empty when all is well.
std::string shared_cores_warning(int threads, const std::vector<Place>& places, bool over_mpi);

/// The layout for --gps auto and --renderers auto: the one in which frames of these views are foreseen to
/// take least, on the described machine or on this one. All ranks measure what a message costs; rank 0 prints
/// its choice on stderr. Layouts whose GPs cannot hold their slices are left out. `cameras` are needed on
/// rank 0 only; without any, the options' own view counts. All ranks call it before the volume is loaded; all
/// throw the same InputError.
Layout choose_roles(const RenderOptions& options, const std::vector<Camera>& cameras, const Grid& grid,
                    const LoadOptions& load, const std::vector<Place>& places, Launch& launch);

/// How many Renderers get regions: all, but two for each core when colocated ranks share cores. More would
/// not draw faster, and each one's token passes all slices.
int drawing_renderers(const Layout& layout, const std::vector<Place>& places, const Launch& launch);

}  // namespace ringsplat::app
