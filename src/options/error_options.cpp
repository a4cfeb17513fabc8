// Options of errors and truths.
#include <fmt/format.h>

#include <cmath>

#include "base/text.hpp"
#include "options/contradictions.hpp"
#include "options/option_tables.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {

std::string to_string(TruthKind kind) {
  return kind == TruthKind::method ? "method" : kind == TruthKind::field ? "field" : "analytic";
}

TruthKind truth_from(const std::string& name, const std::string& option) {
  return chosen<TruthKind>(
      {{"method", TruthKind::method}, {"field", TruthKind::field}, {"analytic", TruthKind::analytic}}, name,
      option);
}

namespace {

Reader error_above_zero(std::optional<double>& target) {
  return text([&target](const std::string& word, const std::string& option) {
    const double error = read_number<double>(word, option);
    if (!(std::isfinite(error) && error > 0))
      throw InputError(fmt::format("{} {} is no error that a picture could keep", option, error),
                       "give an RMSE above 0 in 1/255, for instance --max-error 0.5");
    target = error;
  });
}

/// Records which settings the user has fixed.
void note_fixed_shortcuts(const OptionList& list, ErrorBudgetOptions& o) {
  if (!o.max_error) return;
  o.fixed_opaque_threshold = list.is_given("--opaque-threshold");
  o.fixed_precision = list.is_given("--precision");
  o.fixed_radius = list.is_given("--radius");
  o.fixed_image_plane = list.is_given("--image-plane");
  o.fixed_slabs = list.is_given("--slabs");
  o.fixed_light_points = list.is_given("--light-points");
  o.fixed_undersample = list.is_given("--undersample");
}

}  // namespace

void add_error_options(OptionList& list, RenderOptions& o) {
  list.below("Error") += {
      {"--error", "method|field", nullptr,
       "Measure the picture against a double-precision truth: the method's own, or the field's integral",
       parsed(o.error.truth, truth_from)},
      {"--error-pixels", "N", initial,
       "Pixels at which the truth is evaluated, drawn at random where the volume may show",
       value(o.error.pixels, {1, std::size_t(1) << 30})},
      {"--error-seed", nullptr, initial, "Seed of that draw", value(o.error.seed)},
      {"--max-error", "RMSE", nullptr,
       "Choose the cheapest --opaque-threshold, --precision, --radius, --slabs, --light-points, "
       "--image-plane and --undersample whose RMSE against the method's truth stays within this, in 1/255; "
       "with --error field against the field's, and --engine, too; those given are kept",
       error_above_zero(o.budget.max_error)},
  };
}

void add_reference_options(OptionList& list, ReferenceOptions& o) {
  list.below("Truth") += {
      {"--truth", "method|field|analytic", "field",
       "The method's own picture (--quality), the integral of the interpolated volume, or that of the "
       "formula it was made from",
       parsed(o.truth, truth_from)},
      {"--tolerance", nullptr, initial, "Error of the integral that is allowed in a final colour",
       value(o.tolerance, {1e-12, 0.1})},
      {"--formula", "NAME", nullptr, "Analytic truth: the test volume's name (ringsplat synth --list)",
       value(o.formula)},
  };
  list.below("Output") += {
      {"-o,--output", "FILE", nullptr, "The picture: .exr (linear float32), or an 8-bit format",
       value(o.picture.output), Mark::required},
      {"--background", "COLOUR", "none", "A name, #rrggbb or r,g,b from 0 to 1; makes the picture opaque",
       parsed(o.picture.background, parse_colour)},
  };
}

void check_values_file(const RenderOptions& o) {
  if (o.colour.values && !o.output.empty() && !detail::lower_case(o.output).ends_with(".exr"))
    throw InputError(fmt::format("-o {} cannot hold --values", o.output), "write an .exr");
}

void settle_mode(const OptionList& list, RenderOptions& o) {
  // Of fluorescence the largest values show most, where the other options allow a mode.
  const bool mip = std::holds_alternative<Sheets>(o.frame.how) && !list.is_given("--mode") &&
                   o.colour.interpolation != Interpolation::nearest;
  if (mip && names_channels(o.volume.choice.channel)) o.colour.mode = Mode::mip;
}

void settle_picture(const OptionList& list, RenderOptions& o) {
  check_values_file(o);
  settle_fit(list, o);
  o.frame.how = method_for(o.method);
  settle_mode(list, o);
  note_fixed_shortcuts(list, o.budget);
  if (o.budget.max_error && !o.error.truth) o.error.truth = TruthKind::method;
  o.budget.to_field = o.budget.max_error && *o.error.truth == TruthKind::field;
  // A method's truth is its own, so that only the field's tells which engine is nearer.
  if (o.budget.to_field && !engine_is_chosen(list)) o.budget.other_engine = method_for_other_engine(o.method);
}

void note_options_without_effect(const OptionList& list, ReferenceOptions& o) {
  // No truth uses kernel tables or regions; a field's truth uses no kernel and no slices.
  std::vector<const char*> unknown{"--kernel", "--phases", "--qee-bits", "--region"};
  if (o.truth == TruthKind::method)
    unknown.push_back("--tolerance");
  else
    unknown.insert(unknown.end(), {"--radius", "--normalisation", "--no-opacity-correction", "--engine",
                                   "--quality", "--slabs", "--light-points"});
  for (const char* name : unknown)
    if (list.is_given(name)) o.without_effect.emplace_back(name);
}

}  // namespace ringsplat::app
