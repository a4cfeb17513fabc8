#include "options/reference_options.hpp"

#include <fmt/format.h>

#include "options/option_tables.hpp"
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

namespace {

using Error = ErrorOptions;
constexpr OptionRow<Error> error_rows[] = {
    {"--error", "method|field", nullptr,
     "Measure the picture against a double-precision truth: the method's own, or the field's integral",
     [](Error& o) { return parsed(o.truth, truth_from); }},
    {"--error-pixels", "N", initial,
     "Pixels at which the truth is evaluated, drawn at random where the volume may show",
     [](Error& o) {
       return value(o.pixels, {1, std::size_t(1) << 30});
     }},
    {"--error-seed", nullptr, initial, "Seed of that draw", [](Error& o) { return value(o.seed); }},
};

using Reference = ReferenceOptions;
constexpr OptionRow<Reference> truth_rows[] = {
    {"--truth", "method|field|analytic", "field",
     "The method's own picture (--quality), the integral of the interpolated volume, or that of the formula "
     "it "
     "was made from",
     [](Reference& o) { return parsed(o.truth, truth_from); }},
    {"--tolerance", nullptr, initial, "Error of the integral that is allowed in a final colour",
     [](Reference& o) {
       return value(o.tolerance, {1e-12, 0.1});
     }},
    {"--formula", "NAME", nullptr, "Analytic truth: the test volume's name (ringsplat synth --list)",
     [](Reference& o) { return value(o.formula); }},
};

constexpr OptionRow<Reference> reference_output_rows[] = {
    {"-o,--output", "FILE", nullptr, "The picture: .exr (linear float32), or an 8-bit format",
     [](Reference& o) { return value(o.picture.output); }, Mark::required},
};

using Study = StudyOptions;
constexpr OptionRow<Study> study_rows[] = {
    {"list", "LIST.toml", nullptr,
     "TOML file of scenes, views and settings; without one, the list that --list prints",
     [](Study& o) { return value(o.list); }},
    {"-o,--output", "FILE.csv", nullptr,
     "Table of results, one line each measurement; a .json is written beside it",
     [](Study& o) { return value(o.output); }},
    {"--keep-images", "FOLDER", nullptr,
     "Keep every picture, and the whole truths but the method's, as PNG over black; the table names them",
     [](Study& o) { return value(o.pictures); }},
    {"--list", nullptr, nullptr, "Print the default list and be done",
     [](Study& o) { return flag(o.show_list); }},
};

}  // namespace

constexpr OptionGroup<Error> error_options{"Error", error_rows};
constexpr OptionGroup<Reference> truth_options{"Truth", truth_rows};
constexpr OptionGroup<Reference> reference_output_options{"Output", reference_output_rows};
constexpr OptionGroup<Study> study_options{"Output", study_rows};

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
