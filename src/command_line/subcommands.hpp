#pragma once
#include <span>
#include <string>
#include <variant>

#include "options/option_list.hpp"
#include "options/reference_options.hpp"

namespace ringsplat::app {

/// A text to print on stdout, and nothing else to do (--help, --version, --man).
struct Say {
  std::string text;
};

/// What to do; nothing when the command line was wrong.
using Command = std::variant<std::monostate, Say, RenderOptions, ServeOptions, InfoOptions, CompareOptions,
                             SynthOptions, ReferenceOptions, StudyOptions>;

/// What the options of all subcommands are bound to.
struct AllOptions {
  RenderOptions render;
  ServeOptions serve;
  InfoOptions info;
  CompareOptions compare;
  SynthOptions synth;
  ReferenceOptions reference;
  StudyOptions study;
};

struct Subcommand {
  const char* name;
  const char* description;
  const char* config;    ///< what lines of a --config file may be
  const char* examples;  ///< command lines, indented
  const char* everyday;  ///< the options that --help shows, with blanks between; empty: all
  void (*add_options)(OptionList& list, AllOptions& options);
  /// Completes the options once they are read, and returns them. Throws InputError when something is
  /// missing.
  Command (*settle)(const OptionList& list, AllOptions& options);
};

/// A subcommand and its options, bound to their targets.
struct BoundSubcommand {
  const Subcommand* what;
  OptionList options;
};

/// In the order of --help.
std::span<const Subcommand> subcommands();

}  // namespace ringsplat::app
