#include "options/error_budget_options.hpp"

#include <fmt/format.h>

#include <cmath>

#include "options/option_tables.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

using Budget = ErrorBudgetOptions;

Binding error_above_zero(std::optional<double>& target) {
  return handed<double>([&target](const double& value) {
    if (!(std::isfinite(value) && value > 0))
      throw InputError(fmt::format("--max-error {} is no error that a picture could keep", value),
                       "give an RMSE above 0 in 1/255, for instance --max-error 0.5");
    target = value;
  });
}

constexpr OptionRow<Budget> error_budget_rows[] = {
    {"--max-error", "RMSE", nullptr,
     "Choose the cheapest --opaque-threshold, --precision, --radius, --slabs, --light-points, --image-plane "
     "and --undersample whose RMSE against the method's truth stays within this, in 1/255; with --error "
     "field "
     "against the field's, and --engine, too; those given are kept",
     [](Budget& o) { return error_above_zero(o.max_error); }},
};

}  // namespace

constexpr OptionGroup<Budget> error_budget_options{"Error", error_budget_rows};

void note_fixed_shortcuts(const CLI::App& app, ErrorBudgetOptions& o) {
  const auto given = [&](const char* name) {
    const CLI::Option* const option = app.get_option_no_throw(name);
    return option != nullptr && option->count() > 0;
  };
  if (!o.max_error) return;
  o.fixed_opaque_threshold = given("--opaque-threshold");
  o.fixed_precision = given("--precision");
  o.fixed_radius = given("--radius");
  o.fixed_image_plane = given("--image-plane");
  o.fixed_slabs = given("--slabs");
  o.fixed_light_points = given("--light-points");
  o.fixed_undersample = given("--undersample") || given("--progressive");
}

}  // namespace ringsplat::app
