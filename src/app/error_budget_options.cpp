#include "app/error_budget_options.hpp"

#include <fmt/format.h>

#include <cmath>

#include "ringsplat/base/error.hpp"

namespace ringsplat::app {

void add_error_budget_options(CLI::App& app, ErrorBudgetOptions& o) {
  const auto take = [&o](const double& value) {
    if (!(std::isfinite(value) && value > 0))
      throw InputError(fmt::format("--max-error {} is no error that a picture could keep", value),
                       "give an RMSE above 0 in 1/255, for instance --max-error 0.5");
    o.max_error = value;
  };
  app.add_option_function<double>(
         "--max-error", take,
         "Choose the cheapest --opaque-threshold, --precision, --radius, --image-plane and "
         "--undersample whose RMSE against the method's truth stays within this, in 1/255; those given are "
         "kept")
      ->type_name("RMSE")
      ->group("Error");
}

void note_fixed_shortcuts(const CLI::App& app, ErrorBudgetOptions& o) {
  const auto given = [&](const char* name) { return app.get_option(name)->count() > 0; };
  if (!o.max_error) return;
  if (given("--error"))
    throw InputError(
        "--max-error and --error contradict each other",
        "--max-error measures each picture against the method's truth itself: leave out --error");
  o.fixed_opaque_threshold = given("--opaque-threshold");
  o.fixed_precision = given("--precision");
  o.fixed_radius = given("--radius");
  o.fixed_image_plane = given("--image-plane");
  o.fixed_undersample = given("--undersample") || given("--progressive");
}

}  // namespace ringsplat::app
