#pragma once
#include <optional>
#include <string>
#include <vector>

#include "app/annotation.hpp"
#include "app/frame_output.hpp"
#include "app/series.hpp"
#include "options/options.hpp"
#include "options/transfer_function_option.hpp"
#include "program/launch.hpp"
#include "program/progress.hpp"
#include "scene/scene.hpp"

namespace ringsplat::app {

/// What only rank 0 knows, as only it reads the small files and writes the results.
struct Plan {
  std::optional<TransferFunctionChoice> transfer_function;
  std::vector<Camera> cameras;
};

/// A run, all decided and checked before a voxel is read.
struct Job {
  RenderOptions options;
  Layout layout;
  Plan plan;
  std::vector<SeriesEntry> series;       ///< one volume, without --frames
  OpenedVolume volume;                   ///< the first of them
  std::string view_note;                 ///< on rank 0: what is said of the view, or nothing
  std::optional<Annotation> annotation;  ///< on rank 0
  LoadOptions load;
  SliceMemory memory;
  std::vector<MeasuredShortcuts> measured;  ///< on rank 0, for --max-error: of what a setting is chosen
};

/// Opens the volume and decides on everything that a run needs to know before loading. All ranks call it, and
/// throw the same InputError.
Job prepare(const RenderOptions& given, Launch& launch);

/// Throws InputError when the frame's view cannot be rendered at some level.
void check_view(const RenderOptions& o, FrameSpec spec, const Grid& grid);

/// The part that all frames share, with the transfer function for the loaded scene, and under --max-error the
/// shortcuts. May load the scene again, for another engine or after a calibration. On all ranks; the result
/// is rank 0's.
FrameSpec choose_frame(Job& job, Scene& scene, const Wiring& wiring, Progress& progress, Launch& launch);

/// Loads the scene again, from the same volume.
Scene reload(Job& job, const Wiring& wiring, Progress& progress, Launch& launch);

/// Draws the volumes of --frames.
ExitCode render_series(Job& job, Progress& progress, Launch& launch);

}  // namespace ringsplat::app
