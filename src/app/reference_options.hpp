#pragma once
#include <string>
#include <vector>

#include "app/options.hpp"

namespace CLI {
class App;
}

namespace ringsplat::app {

struct ReferenceOptions {
  RenderOptions picture;  ///< volume, views, transfer function, shading, output
  TruthKind truth = TruthKind::field;
  double tolerance = 1e-6;
  std::string formula;  ///< analytic truth: the field of synth_names() that the volume was sampled from
  std::vector<std::string> without_effect;  ///< options that were given and that this truth does not know
};

struct StudyOptions {
  std::string list;      ///< TOML file of scenes, views and settings; empty: the default list
  std::string output;    ///< .csv; the same name with .json is written too
  std::string pictures;  ///< folder that keeps every picture and truth; empty: none is kept
  bool show_list = false;
};

/// Takes down which of a parsed subcommand's options change nothing: of render's, with which a truth is asked
/// for, not all concern it.
void note_options_without_effect(const CLI::App& app, ReferenceOptions& options);

}  // namespace ringsplat::app
