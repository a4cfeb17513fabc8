#pragma once
#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/annotation.hpp"
#include "app/channels.hpp"
#include "app/frame_output.hpp"
#include "app/series.hpp"
#include "options/options.hpp"
#include "options/transfer_function_option.hpp"
#include "program/launch.hpp"
#include "program/progress.hpp"
#include "scene/scene.hpp"
#include "session/render_frames.hpp"

namespace ringsplat::app {

struct Place {
  std::string machine;
  std::vector<int> cores;  ///< that the rank may use
};

/// A run, all decided and checked before a voxel is read.
struct Job {
  RenderOptions options;
  std::vector<Place> places;  ///< by rank
  Layout layout;
  // On rank 0, as only it reads the small files and writes the results.
  std::optional<TransferFunctionChoice> transfer_function;
  std::vector<Camera> cameras;
  /// One volume without --frames; of several channels each volume's in turn.
  std::vector<SeriesEntry> series;
  std::vector<DrawnChannel> channels;    ///< that are drawn together, on all ranks as many; else none
  OpenedVolume volume;                   ///< the first of them
  std::optional<Annotation> annotation;  ///< on rank 0
  LoadOptions load;
  std::vector<std::uint64_t> slice_bytes;   ///< foreseen, by GP
  std::vector<MeasuredShortcuts> measured;  ///< on rank 0, for --max-error: of what a setting is chosen

  std::size_t channels_drawn() const { return std::max<std::size_t>(1, channels.size()); }
  std::size_t volumes() const { return series.size() / channels_drawn(); }
};

// Where the ranks run, and what follows from it.

/// Cores of all machines that the ranks share; a machine counts at most one a rank.
int shared_cores(const std::vector<Place>& places);

/// How many ranks may work when no option says it: one for each core. On several machines, and simulated
/// ones, all: the last ranks could be all of one machine's.
int ranks_with_cores(const std::vector<Place>& places);

/// The threads that this rank takes when no option says it: its machine's cores, shared evenly by those of
/// the first `working` ranks that run there, but no more than it may use; at least 1.
int fair_threads(const std::vector<Place>& places, int rank, int working);

/// The warning when ranks of `threads` threads have too few cores; empty when all is well.
std::string shared_cores_warning(int threads, const std::vector<Place>& places, bool over_mpi);

/// Chooses the layout, the patience with slow ranks and the threads of this rank's engine. Warns on rank 0
/// when threads that were asked for have to share cores. Collective; throws InputError on all ranks.
void settle_ranks(Job& job, Launch& launch);

/// Chooses roles where that is left to the program, says how many Renderers get regions, predicts what the
/// slices of so many volumes take that are held at once, and logs what this rank does. Throws InputError on
/// all ranks when some process's slices, or its frame buffer, which holds so many `pictures` at once, exceed
/// the machine's memory.
void settle_layout(Job& job, std::size_t pictures, std::size_t volumes, Launch& launch);

// What all runs do that render a volume.

/// All ranks call it; all throw the same InputError.
OpenedVolume open(const VolumeOptions& volume, Launch& launch);

/// Stands for a function that may need the histogram of a volume that is not loaded yet, where the rest of a
/// frame is checked.
TransferFunction stand_in_function();

/// Bytes that this process may hold of the next volume of a series while one is drawn: as many as it holds of
/// one volume's slices, or none where the machine has no room for so many beside slices and pictures.
std::size_t room_to_read_ahead(const Job& job, std::size_t pictures, const Launch& launch);

/// Deals an opened volume of the job and closes it. Throws InputError when it has no finite value.
Scene load(const Job& job, OpenedVolume& volume, Progress& progress, Launch& launch);

/// Renders all of rank 0's director's frames. Every input was checked on all ranks before, so an error here
/// ends the job.
void render_all(const Job& job, const ProtocolOptions& protocol, Scene scene, Director director,
                Launch& launch);

/// Most pictures of so many views that rank 0 holds at once: sums of channels wait for the last one.
std::size_t pictures_at_once(const Job& job, std::size_t views);

/// Finds the job's volumes, in all channels that are drawn together, and opens the first. All ranks call it,
/// and throw the same InputError.
void find_volumes(Job& job, Launch& launch);

/// Opens the volume and decides on everything that a run needs to know before loading. All ranks call it, and
/// throw the same InputError.
Job prepare(const RenderOptions& given, Launch& launch);

/// The part that all frames share, with the transfer function for the loaded scene, and under --max-error the
/// shortcuts. May load the scene again, for another engine or after a calibration. `channel`: of those drawn
/// together, that of the scene. On all ranks; the result is rank 0's.
FrameSpec choose_frame(Job& job, Scene& scene, Progress& progress, Launch& launch, std::size_t channel = 0);

/// Loads the scene again, from the same volume.
Scene reload(Job& job, Progress& progress, Launch& launch);

/// Draws one of the job's volumes and channels: with --frames one view of it, else all. `sum` gets the
/// pictures.
void draw(const Job& job, std::size_t k, Scene scene, const FrameSpec& frame, FrameSum& sum, Launch& launch);

/// Changes `frame` (on rank 0, which announces frames) to the cheapest setting that keeps the job's budget,
/// by the stored calibration or a new one. All processes call it. Returns true when it rendered with `scene`,
/// which is then used up and must be loaded again. All throw the same InputError when no setting keeps the
/// budget.
bool keep_budget(Job& job, Scene& scene, FrameSpec& frame, Progress& progress, Launch& launch);

/// The pictures of a run, on rank 0.
struct Gallery {
  std::function<std::vector<Judged>()> judge;       ///< those that were not judged before
  std::function<void(FrameResult&&)> replace = {};  ///< the picture of the frame with this number
};

/// Draws pictures that break the budget again, with more exact settings, twice at most. All processes call
/// it, after keep_budget and the run. Warns of each picture that is over the budget then; returns whether
/// there is none.
bool hold_budget(Job& job, const Gallery& gallery, Progress& progress, Launch& launch);

}  // namespace ringsplat::app
