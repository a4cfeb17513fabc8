#pragma once
#include <string>

#include "app/options.hpp"

namespace ringsplat::app {

struct ReferenceOptions {
  RenderOptions picture;  ///< volume, views, transfer function, shading, output
  TruthKind truth = TruthKind::field;
  double tolerance = 1e-6;
  std::string formula;  ///< analytic truth: the field of synth_names() that the volume was sampled from
};

struct StudyOptions {
  std::string list;      ///< TOML file of scenes, views and settings; empty: the default list
  std::string output;    ///< .csv; the same name with .json is written too
  std::string pictures;  ///< folder that keeps every picture and truth; empty: none is kept
  bool show_list = false;
};

void add_error_options(CLI::App& app, ErrorOptions& options);
void add_reference_options(CLI::App& app, ReferenceOptions& options);
void add_study_options(CLI::App& app, StudyOptions& options);

}  // namespace ringsplat::app
