#pragma once
#include <string>
#include <vector>

#include "options/options.hpp"

namespace ringsplat::app {

class OptionList;

struct ReferenceOptions {
  RenderOptions picture;  ///< volume, views, transfer function, shading, output
  TruthKind truth = TruthKind::field;
  double tolerance = 1e-6;
  std::string formula;  ///< analytic truth: the field in synth_names() that the volume samples
  std::vector<std::string> without_effect;  ///< given options that this truth ignores
};

struct StudyOptions {
  std::string list;      ///< TOML file of scenes, views and settings; empty: the default list
  std::string output;    ///< .csv; the same name with .json is written too
  std::string pictures;  ///< folder that keeps every picture and truth; empty: none is kept
  bool show_list = false;
};

/// Records which given options change nothing: it takes render's options, and not all
/// concern a truth.
void note_options_without_effect(const OptionList& list, ReferenceOptions& options);

}  // namespace ringsplat::app
