#include "options/error_budget_options.hpp"

#include <fmt/format.h>

#include <cmath>

#include "options/option_tables.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

using Budget = ErrorBudgetOptions;

Reader error_above_zero(std::optional<double>& target) {
  return text([&target](const std::string& word, const std::string& option) {
    const double error = read_number<double>(word, option);
    if (!(std::isfinite(error) && error > 0))
      throw InputError(fmt::format("{} {} is no error that a picture could keep", option, error),
                       "give an RMSE above 0 in 1/255, for instance --max-error 0.5");
    target = error;
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

void note_fixed_shortcuts(const OptionList& list, ErrorBudgetOptions& o) {
  if (!o.max_error) return;
  o.fixed_opaque_threshold = list.is_given("--opaque-threshold");
  o.fixed_precision = list.is_given("--precision");
  o.fixed_radius = list.is_given("--radius");
  o.fixed_image_plane = list.is_given("--image-plane");
  o.fixed_slabs = list.is_given("--slabs");
  o.fixed_light_points = list.is_given("--light-points");
  o.fixed_undersample = list.is_given("--undersample") || list.is_given("--progressive");
}

}  // namespace ringsplat::app
