#pragma once
#include <optional>
#include <string>
#include <vector>

#include "options/option_values.hpp"
#include "options/options.hpp"
#include "program/launch.hpp"
#include "program/progress.hpp"
#include "scene/scene.hpp"
#include "volume/read_ahead.hpp"

namespace ringsplat::app {

struct Job;

/// A volume of a series.
struct SeriesEntry {
  int number = 0;  ///< of its picture: the one that --frames counts by
  VolumeOptions volume;
  std::string name;     ///< for people, without folders: "step_0012.nrrd", "film.nii, frame 12"
  std::string channel;  ///< its name, where it is drawn with others

  std::string full_name() const { return channel.empty() ? name : name + ", " + channel; }
};

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

/// The volumes that are asked for: without --frames the one. Rank 0 looks for them; all ranks call it, get
/// the same list, and throw the same InputError.
std::vector<SeriesEntry> find_series(const VolumeOptions& volume, const std::optional<FrameRange>& frames,
                                     Launch& launch);

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
  /// The same in all channels: the first, and the others beside it.
  Scene load_channels(std::size_t volume);
  /// Begins to read a volume that will probably be loaded next. None of that number, or one that cannot be
  /// opened: nothing happens, as load() will tell.
  void read_ahead(std::size_t k);

 private:
  OpenedVolume opened(std::size_t k);
  OpenedVolume open_like_the_first(std::size_t k);

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
