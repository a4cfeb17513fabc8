#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/error_budget_options.hpp"
#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat::app {

/// What an error budget may trade for speed (docs/accuracy.md, "An error budget").
struct Shortcuts {
  double opaque_threshold = 0;
  Precision precision = Precision::float32;
  double radius = 1.6;  ///< of the kernel, in lattice distances
  ImagePlane plane = ImagePlane::screen;
  int samples = 1;  ///< in the slices' plane
  int undersample = 1;
  bool operator==(const Shortcuts&) const = default;
};

/// The frame as `shortcuts` would render it.
FrameSpec with(FrameSpec frame, const Shortcuts& shortcuts);

/// All factors of undersampling among the candidates, where the user has fixed none.
std::vector<int> levels_to_choose_from();

/// As options of the command line.
std::string to_text(const Shortcuts& shortcuts);

/// All combinations to choose from, the most exact first. What the user has fixed, and what `frame` leaves no
/// choice of (words carry float only), is as `frame` has it.
std::vector<Shortcuts> candidates(const FrameSpec& frame, const ErrorBudgetOptions& options);

struct MeasuredShortcuts {
  Shortcuts shortcuts;
  double seconds = 0;              ///< a frame, mean over the views of each one's median
  double rmse = 0, rmse_high = 0;  ///< of the worst view, in 1/255; the 95 % interval's upper end
};

/// The index of the cheapest whose interval's upper end is within `max_error`. Times within 3 % of the least
/// count as equal, since that is what they are measured to; of those, the least error. Nothing when none
/// keeps the budget.
std::optional<std::size_t> cheapest_within(std::span<const MeasuredShortcuts> measured, double max_error);

/// The index of the least upper end; of equal ones the fastest. `measured` is not empty.
std::size_t most_exact(std::span<const MeasuredShortcuts> measured);

}  // namespace ringsplat::app
