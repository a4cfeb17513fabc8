// Options of errors and truths, and what completes those of a picture.

#include "base/text.hpp"
#include "options/option_tables.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {

TruthKind truth_from(const std::string& word, const std::string& option) {
  using enum TruthKind;
  return chosen(named({method, field, analytic, certified}), word, option);
}

namespace {

double parse_error(const std::string& text, const std::string& option) {
  return parse_positive(text, option, "give an RMSE above 0 in 1/255, for instance --max-error 0.5");
}

void settle_fit(const OptionList& list, RenderOptions& o) {
  for (const char* const name :
       {"--view", "--azimuth", "--elevation", "--matrix", "--eye", "--orbit", "--path", "--slice"})
    o.direction_chosen = o.direction_chosen || list.is_given(name);
  Camera& camera = o.frame.shown.camera;
  if (o.fit && camera.fov > 0 && camera.eye)
    throw InputError("--fit has no effect in perspective with --eye, which is where it is",
                     "leave out --fit, and use --zoom or --fov");
  const bool has_its_size = camera.matrix || (camera.fov > 0 && (camera.eye || camera.distance > 0));
  const bool turns = o.orbit > 0 || !o.path.empty() || !o.views.empty();
  camera.fit = has_its_size ? Fit::sphere : o.fit.value_or(turns ? Fit::sphere : Fit::box);
}

}  // namespace

void add_error_options(OptionList& list, RenderOptions& o) {
  list.below("Error") += {
      {"--error", "method|field|certified", nullptr,
       "Measure the picture against a double-precision truth: the method's own, the field's integral, or "
       "proved bounds of that",
       parsed(o.error.truth, truth_from)},
      {"--error-pixels", "N", initial,
       "Pixels at which the truth is evaluated, drawn at random where the volume may show",
       value(o.error.pixels, {1, std::size_t(1) << 30})},
      {"--error-seed", nullptr, initial, "Seed of that draw", value(o.error.seed)},
      {"--error-map", "FILE", nullptr,
       "A picture of each pixel's error, with certified of what it surely does not exceed; at all pixels "
       "unless --error-pixels says how many",
       value(o.error.map), Mark::of_program},
      {"--max-error", "RMSE", nullptr,
       "Choose the cheapest --opaque-threshold, --slabs, --light-points, --image-plane and --undersample "
       "whose RMSE against the method's truth stays within this, in 1/255; with --error field or certified "
       "against the field's; those given are kept",
       parsed(o.budget.max_error, parse_error), Mark::of_sheets},
      {"--guarantee", nullptr, nullptr,
       "Prove that every pixel errs at most --max-error: those that may err more become the middle of their "
       "bounds",
       flag(o.budget.guarantee)},
  };
}

void add_reference_options(OptionList& list, ReferenceOptions& o) {
  list.below("Truth") += {
      {"--truth", "method|field|analytic|certified", "field",
       "The method's own picture (--quality), the integral of the interpolated volume, that of the formula "
       "it "
       "was made from, or the middle of proved bounds of the field's",
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

void settle_picture(const OptionList& list, RenderOptions& o) {
  const char* const numbers = o.colour.values ? "--values" : o.frame.shown.depth ? "--depth" : nullptr;
  if (numbers != nullptr && !o.output.empty() && !detail::lower_case(o.output).ends_with(".exr"))
    throw InputError(fmt::format("-o {} cannot hold {}", o.output, numbers), "write an .exr");
  settle_fit(list, o);
  o.frame.how = method_for(o.method);
  // Of fluorescence the largest values show most, where the other options allow a mode.
  const bool mip = std::holds_alternative<Sheets>(o.frame.how) && !list.is_given("--mode") &&
                   o.colour.interpolation != Interpolation::nearest && !o.frame.shown.edges &&
                   !o.frame.shown.mixed && !list.is_given("--layers");
  if (mip && names_channels(o.volume.choice.channel)) o.colour.mode = Mode::mip;
  for (const char* const name :
       {"--opaque-threshold", "--image-plane", "--slabs", "--light-points", "--undersample"})
    if (o.budget.max_error && list.is_given(name)) o.budget.fixed.emplace(name);
  if (o.budget.max_error && !o.error.truth) o.error.truth = TruthKind::method;
  o.error.all = o.budget.guarantee || (!o.error.map.empty() && !list.is_given("--error-pixels"));
  if (o.budget.guarantee) o.error.guaranteed = o.budget.max_error;
  // More slabs lessen the error against the field alone.
  o.budget.to_field = o.budget.max_error && *o.error.truth != TruthKind::method;
}

void note_options_without_effect(const OptionList& list, ReferenceOptions& o) {
  // No truth uses regions or layers; a field's truth uses no kernel and no slices.
  std::vector<const char*> unknown{"--region", "--layers"};
  if (o.truth == TruthKind::method || o.truth == TruthKind::certified) unknown.push_back("--tolerance");
  if (o.truth != TruthKind::method)
    unknown.insert(unknown.end(), {"--radius", "--no-opacity-correction", "--engine", "--quality", "--slabs",
                                   "--light-points"});
  for (const char* name : unknown)
    if (list.is_given(name)) o.without_effect.emplace_back(name);
}

}  // namespace ringsplat::app
