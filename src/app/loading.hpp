#pragma once
#include <string>
#include <vector>

#include "app/frame_output.hpp"
#include "options/options.hpp"
#include "program/launch.hpp"
#include "program/progress.hpp"
#include "scene/scene.hpp"
#include "session/render_frames.hpp"

/// What all runs do that render a volume: see where the ranks run, and what follows from it, open the volume,
/// see that it fits into memory, load and render it.
namespace ringsplat::app {

struct Job;

struct Place {
  std::string machine;
  std::vector<int> cores;  ///< that the rank may use
};

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

/// All ranks call it; all throw the same InputError.
OpenedVolume open(const VolumeOptions& volume, Launch& launch);

/// Stands for a function that may need the histogram of a volume that is not loaded yet, where the rest of a
/// frame is checked.
TransferFunction stand_in_function();

/// Chooses roles where that is left to the program, says how many Renderers get regions, predicts what the
/// slices of so many volumes take that are held at once, and logs what this rank does. Throws InputError on
/// all ranks when some process's slices, or its frame buffer, which holds so many `pictures` at once, exceed
/// the machine's memory.
void settle_layout(Job& job, const std::vector<Place>& places, std::size_t pictures, std::size_t volumes,
                   Launch& launch);

/// Bytes that this process may hold of the next volume of a series while one is drawn: as many as it holds of
/// one volume's slices, or none where the machine has no room for so many beside slices and pictures.
std::size_t room_to_read_ahead(const Job& job, std::size_t pictures, const Launch& launch);

/// Deals an opened volume of the job and closes it. Throws InputError when it has no finite value.
Scene load(const Job& job, OpenedVolume& volume, Progress& progress, Launch& launch);

/// Renders all of rank 0's director's frames. Every input was checked on all ranks before, so an error here
/// ends the job.
void render_all(const Job& job, const ProtocolOptions& protocol, Scene scene, Director director,
                Launch& launch);

}  // namespace ringsplat::app
