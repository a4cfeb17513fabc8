#include "app/reference_options.hpp"

#include <fmt/format.h>

#include "ringsplat/base/error.hpp"

namespace ringsplat::app {

std::string to_string(TruthKind kind) {
  return kind == TruthKind::method ? "method" : kind == TruthKind::field ? "field" : "analytic";
}

TruthKind truth_from(const std::string& name, const std::string& option) {
  for (const TruthKind kind : {TruthKind::method, TruthKind::field, TruthKind::analytic})
    if (name == to_string(kind)) return kind;
  throw InputError(fmt::format("{} cannot be '{}'", option, name),
                   fmt::format("use {} method|field|analytic", option));
}

void add_error_options(CLI::App& app, ErrorOptions& o) {
  const auto choose = [&o](const std::string& text) {
    o.truth = truth_from(text, "--error");
    if (o.truth == TruthKind::analytic)
      throw InputError("--error analytic needs a formula, which a picture's volume does not name",
                       "use ringsplat reference --truth analytic --formula NAME, then ringsplat compare");
  };
  app.add_option_function<std::string>(
         "--error", choose,
         "Measure the picture against a double-precision truth: the method's own, or the field's integral")
      ->type_name("method|field")
      ->group("Error");
  app.add_option("--error-pixels", o.pixels,
                 "Pixels at which the truth is evaluated, drawn at random where the volume may show")
      ->type_name("N")
      ->check(CLI::Range(std::size_t(1), std::size_t(1) << 30))
      ->capture_default_str()
      ->group("Error");
  app.add_option("--error-seed", o.seed, "Seed of that draw")->capture_default_str()->group("Error");
}

void add_reference_options(CLI::App& app, ReferenceOptions& o) {
  app.add_option_function<std::string>(
         "--truth", [&o](const std::string& text) { o.truth = truth_from(text, "--truth"); },
         "The splatting method's own picture, the integral of the interpolated volume, or that of the "
         "formula it was made from")
      ->type_name("method|field|analytic")
      ->default_str("field")
      ->group("Truth");
  app.add_option("--tolerance", o.tolerance, "Error of the integral that is allowed in a final colour")
      ->capture_default_str()
      ->check(CLI::Range(1e-12, 0.1))
      ->group("Truth");
  app.add_option("--formula", o.formula, "Analytic truth: the test volume's name (ringsplat synth --list)")
      ->type_name("NAME")
      ->group("Truth");
  app.add_option("-o,--output", o.picture.output, "The picture: .exr (linear float32), or an 8-bit format")
      ->type_name("FILE")
      ->required()
      ->group("Output");
}

void note_options_without_effect(const CLI::App& app, ReferenceOptions& o) {
  // A truth has no tables and no regions, and that of a field no kernel and no slices.
  std::vector<const char*> unknown{"--kernel", "--phases", "--qee-bits", "--region"};
  if (o.truth == TruthKind::method)
    unknown.push_back("--tolerance");
  else
    unknown.insert(unknown.end(), {"--radius", "--normalisation", "--no-opacity-correction"});
  for (const char* name : unknown)
    if (app.get_option(name)->count() > 0) o.without_effect.emplace_back(name);
}

void add_study_options(CLI::App& app, StudyOptions& o) {
  app.add_option("list", o.list,
                 "TOML file of scenes, views and settings; without one, the list that --list prints")
      ->type_name("LIST.toml");
  app.add_option("-o,--output", o.output,
                 "Table of results, one line each measurement; a .json is written beside it")
      ->type_name("FILE.csv")
      ->group("Output");
  app.add_option(
         "--keep-images", o.pictures,
         "Keep every picture, and the whole truths but the method's, as PNG over black; the table names them")
      ->type_name("FOLDER")
      ->group("Output");
  app.add_flag("--list", o.show_list, "Print the default list and be done")->group("Output");
}

}  // namespace ringsplat::app
