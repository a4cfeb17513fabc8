#pragma once
#include <optional>

namespace CLI {
class App;
}

namespace ringsplat::app {

struct ErrorBudgetOptions {
  std::optional<double> max_error;  ///< RMSE in 1/255 against the method's truth; nothing: choose nothing
  /// Settings that the user gave, so they are not chosen.
  bool fixed_opaque_threshold = false, fixed_precision = false, fixed_radius = false,
       fixed_image_plane = false, fixed_undersample = false;
};

/// Records which settings the user of a parsed subcommand has fixed.
void note_fixed_shortcuts(const CLI::App& app, ErrorBudgetOptions& options);

}  // namespace ringsplat::app
