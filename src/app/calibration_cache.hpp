#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/error_budget.hpp"
#include "app/options.hpp"
#include "ringsplat/volume/statistics.hpp"

/// Calibrations of the error budget kept from run to run, one file each. Rank 0 only.
namespace ringsplat::app {

/// All that a calibration depends on, as JSON text: the program, the volume's file (absolute path, size, time
/// of its last change) and values (histogram), the frame but for its view, the views measured, the choice,
/// the layout and the sample of pixels.
std::string calibration_key(const RenderOptions& options, const FrameSpec& reference, const Layout& layout,
                            const Histogram& histogram, const std::vector<Camera>& views);

/// $XDG_CACHE_HOME/ringsplat, else ~/.cache/ringsplat (XDG base directory specification; a relative
/// XDG_CACHE_HOME is ignored, as it asks); nothing when there is no home either.
std::optional<std::filesystem::path> cache_folder();

/// The file of `key` in `folder`.
std::filesystem::path calibration_file(const std::filesystem::path& folder, const std::string& key);

/// What the file says when it was written for `key`: a measurement for each of `settings`, in their order.
/// Nothing when there is no file; when it cannot be understood a warning is logged as well.
std::optional<std::vector<MeasuredShortcuts>> read_calibration(const std::filesystem::path& file,
                                                               const std::string& key,
                                                               const std::vector<Shortcuts>& settings);

/// Makes the folder when it is missing; writes beside and renames. Only warns when that fails: the
/// calibration is then made again next time.
void write_calibration(const std::filesystem::path& file, const std::string& key,
                       const std::vector<MeasuredShortcuts>& measured);

}  // namespace ringsplat::app
