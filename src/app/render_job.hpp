#pragma once
#include <algorithm>
#include <cstddef>
#include <functional>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "app/annotation.hpp"
#include "app/channels.hpp"
#include "app/frame_output.hpp"
#include "options/options.hpp"
#include "options/transfer_function_option.hpp"
#include "program/launch.hpp"
#include "program/progress.hpp"
#include "scene/scene.hpp"
#include "session/render_frames.hpp"
#include "volume/read_ahead.hpp"

namespace ringsplat::app {

/// A volume of a series.
struct SeriesEntry {
  int number = 0;  ///< of its picture: the one that --frames counts by
  std::string path;
  std::optional<int> frame;  ///< of a file with several
  std::string name;          ///< for people, without folders: "step_0012.nrrd", "film.nii, frame 12"
};

struct Binding {
  std::string machine;
  std::vector<int> cores;  ///< that the rank may use
};

/// A run, all decided and checked before a voxel is read.
struct Job {
  RenderOptions options;
  std::vector<Binding> bindings;  ///< by rank
  Layout layout;
  // On rank 0, as only it reads the small files and writes the results.
  std::optional<TransferFunctionChoice> transfer_function;
  std::vector<Camera> cameras;
  std::vector<SeriesEntry> series;         ///< one volume without --frames
  std::vector<DrawnChannel> channels;      ///< that are drawn together, on all ranks as many; else none
  OpenedVolume volume;                     ///< the first part
  std::optional<Annotation> annotation;    ///< on rank 0
  std::shared_future<void> image_library;  ///< for pictures that rank 0 writes
  LoadOptions load;
  std::vector<std::uint64_t> slice_bytes;   ///< foreseen, by GP
  std::vector<MeasuredShortcuts> measured;  ///< on rank 0, for --max-error: of what a setting is chosen

  std::size_t channels_drawn() const { return std::max<std::size_t>(1, channels.size()); }
  /// What is loaded one after another: the volumes, of several channels each volume's in turn.
  std::size_t parts() const { return series.size() * channels_drawn(); }
  VolumeOptions part(std::size_t k) const;
  std::string name_of_part(std::size_t k) const;  ///< for people
};

// All ranks call what takes a Launch&, in the same order, and throw the same InputError.

// Where the ranks run, and what follows from it.

/// Cores of all machines that the ranks share; a machine counts at most one a rank.
int shared_cores(const std::vector<Binding>& bindings);

/// How many ranks may work when no option says it: one for each core. On several machines, and simulated
/// ones, all: the last ranks could be all of one machine's.
int ranks_with_cores(const std::vector<Binding>& bindings);

/// The threads that this rank takes when no option says it: its machine's cores, shared evenly by those of
/// the first `working` ranks that run there, but no more than it may use; at least 1.
int fair_threads(const std::vector<Binding>& bindings, int rank, int working);

/// The warning when ranks of `threads` threads have too few cores; empty when all is well.
std::string shared_cores_warning(int threads, const std::vector<Binding>& bindings, bool over_mpi);

/// Chooses the layout, the patience with slow ranks and the threads of this rank's engine. Warns on rank 0
/// when threads that were asked for have to share cores.
void settle_ranks(Job& job, Launch& launch);

/// Chooses roles where that is left to the program, says how many Renderers get regions, predicts what the
/// slices of so many volumes take that are held at once, and logs what this rank does. Throws InputError when
/// some machine's slices, or its frame buffer, which holds so many `pictures` at once, exceed its memory.
void settle_layout(Job& job, std::size_t pictures, std::size_t volumes, Launch& launch);

/// Throws the InputError of settle_layout() where this machine's part of `volumes` of the job's series
/// exceeds its memory.
void check_memory(const Job& job, std::size_t pictures, const Launch& launch, double volumes = 1);

// What all runs do that render a volume.

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

/// Throws InputError when a file cannot be written.
void check_outputs(const RenderOptions& options);

/// Finds the job's volumes, in all channels that are drawn together, and opens the first.
void find_volumes(Job& job, Launch& launch);

/// Opens the volume and decides on everything that a run needs to know before loading.
Job prepare(const RenderOptions& given, Launch& launch);

/// The part that all frames share, with the transfer function for the loaded scene, and under --max-error the
/// shortcuts. May load the scene again, for another engine or after a calibration. `channel`: of those drawn
/// together, that of the scene. On all ranks; the result is rank 0's.
FrameSpec choose_frame(Job& job, Scene& scene, Progress& progress, Launch& launch, std::size_t channel = 0);

/// Those of all channels in the scene.
std::vector<FrameSpec> choose_frames(Job& job, Scene& scene, Progress& progress, Launch& launch);

/// Loads the scene again, from the same volume.
Scene reload(Job& job, Progress& progress, Launch& launch);

/// Of one of the job's volumes: with --frames one view of it, else all. `frames`: by channel. The job must
/// outlive it.
Director director_of(const Job& job, std::size_t volume, const std::vector<FrameSpec>& frames,
                     std::function<void(FrameResult&&)> take);

/// Changes `frame` (on rank 0, which announces frames) to the cheapest setting that keeps the job's budget,
/// as measured at some of its views. Loads the scene again. Throws InputError when no setting keeps the
/// budget.
void keep_budget(Job& job, Scene& scene, FrameSpec& frame, Progress& progress, Launch& launch);

/// The pictures of a run, on rank 0.
struct Gallery {
  std::function<std::vector<Judged>()> judge;       ///< on all ranks: those that were not judged before
  std::function<void(FrameResult&&)> replace = {};  ///< the picture of the frame with this number
};

/// Draws pictures that break the budget again, with more exact settings, twice at most. Call it after
/// keep_budget and the run. Warns of each picture that is over the budget then; returns whether there is
/// none.
bool hold_budget(Job& job, const Gallery& gallery, Progress& progress, Launch& launch);

// Series of volumes.

/// The files that a pattern means, in order, with the numbers by which --frames counts them: one %d or %04d
/// in the last part of the path is the number in the names; of *, ? and [...] the files are counted from 0 in
/// natural order (2 before 10). What follows ":/" is a place within each file. Throws InputError when it is
/// no pattern, or nothing fits it.
std::vector<std::pair<int, std::string>> files_of_pattern(const std::string& pattern);

/// The chosen ones of `count` frames that are numbered from 0, or of those that `numbers` has, ascending.
/// Throws InputError for a frame that is not there, where both ends are given, and for an empty choice.
/// `what` they are frames of is for messages.
std::vector<int> chosen_frames(const FrameRange& range, const std::vector<int>& numbers,
                               const std::string& what);

/// The volumes that are asked for: without --frames the one, and `more` that are named one by one. Throws
/// InputError when they cannot be found.
std::vector<SeriesEntry> find_series(const VolumeOptions& volume, const std::optional<FrameRange>& frames,
                                     const std::vector<std::string>& more);

/// Loads the volumes of a series, one at a time, all of one grid. While one is drawn a thread of each process
/// reads of the next what the process was asked for of the last one; it calls no MPI. All processes call all
/// functions in the same order.
class SeriesLoader {
 public:
  /// Takes the job's opened volume. So many `pictures` are held at once beside the slices. What is passed by
  /// reference must outlive the loader. `progress` shows how far the first volume is.
  SeriesLoader(Job& job, std::size_t pictures, Progress& progress, Launch& launch);

  /// Throws the same InputError on all processes, with the volume's name, when it cannot be read, has another
  /// grid than the first or no finite value. No scene of an earlier volume should be alive, for its memory.
  Scene load(std::size_t k);
  /// The same in all channels, beside what the scene has; its first becomes the scene where that is empty.
  void load_channels(Scene& scene, std::size_t volume);
  /// Throws the InputError of load(), before anything is loaded, for any that cannot be opened or has another
  /// grid.
  void check_all();
  /// Begins to read a volume that will probably be loaded next. None of that number, or one that cannot be
  /// opened: nothing happens, as load() will tell.
  void read_ahead(std::size_t k);

 private:
  OpenedVolume open_like_the_first(std::size_t k);
  /// A pyramid's next level, or every second voxel of slices that can be left out.
  OpenedVolume half_of(std::size_t k, OpenedVolume whole);

  const Job& job_;
  const std::size_t ahead_bytes_;  ///< this process may hold of a volume that is read ahead
  Progress& progress_;
  Progress silent_{true};
  Launch& launch_;
  const Grid grid_;
  bool loaded_one_ = false;
  std::vector<SliceRun> runs_;  ///< that the last volume was read by
  std::size_t ahead_at_ = 0;
  std::optional<OpenedVolume> ahead_;  ///< volume ahead_at_
};

}  // namespace ringsplat::app
