#pragma once
#include <optional>
#include <string>
#include <vector>

#include "options/frames_option.hpp"
#include "options/options.hpp"
#include "program/launch.hpp"

namespace ringsplat::app {

/// A volume of a series.
struct SeriesEntry {
  int number = 0;  ///< of its picture: the one that --frames counts by
  VolumeOptions volume;
  std::string name;  ///< for people, without folders: "step_0012.nrrd", "film.nii, frame 12"
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

}  // namespace ringsplat::app
