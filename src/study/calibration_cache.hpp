#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "options/options.hpp"
#include "ringsplat/volume/statistics.hpp"
#include "study/error_budget.hpp"

/// Calibrations of the error budget kept from run to run, one file each. Rank 0 only.
namespace ringsplat::app {

/// All that a calibration depends on, as JSON text: the program, the volume's file (absolute path, size, time
/// of its last change) and values (histogram), the frame without its view, the views measured, the truth, the
/// choice, the layout and the sample of pixels.
std::string calibration_key(const RenderOptions& options, const FrameSpec& reference, const Layout& layout,
                            const Histogram& histogram, const std::vector<Camera>& views);

/// What is kept, in a word (program/kept_measurements.hpp).
inline constexpr const char* calibration_kind = "calibration";

/// Reads a file that was written for `key`: a measurement for each of `settings`, in their order. Nothing
/// when there is no such file; warns when it cannot be understood.
std::optional<std::vector<MeasuredShortcuts>> read_calibration(const std::filesystem::path& file,
                                                               const std::string& key,
                                                               const std::vector<Shortcuts>& settings);

void write_calibration(const std::filesystem::path& file, const std::string& key,
                       const std::vector<MeasuredShortcuts>& measured);

}  // namespace ringsplat::app
