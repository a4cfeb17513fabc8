#pragma once
#include <optional>

#include "ringsplat/frame/frame_spec.hpp"

namespace ringsplat::app {

class OptionList;

struct ErrorBudgetOptions {
  std::optional<double> max_error;  ///< RMSE in 1/255 against the chosen truth; nothing: choose nothing
  /// Settings that the user gave, so they are not chosen.
  bool fixed_opaque_threshold = false, fixed_precision = false, fixed_radius = false,
       fixed_image_plane = false, fixed_undersample = false, fixed_slabs = false, fixed_light_points = false;
  bool to_field = false;  ///< the error is against the field's truth, not the method's
  /// What the same options mean for the other engine, where the engine is to be chosen, too.
  std::optional<Method> other_engine;
};

/// Records which settings the user has fixed.
void note_fixed_shortcuts(const OptionList& list, ErrorBudgetOptions& options);

}  // namespace ringsplat::app
