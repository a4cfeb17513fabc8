#pragma once
#include <span>
#include <string>
#include <variant>

#include "options/option_list.hpp"
#include "options/options.hpp"
#include "ringsplat/base/fact.hpp"

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

/// The settings of a subcommand and of the program, option by option, whether from the command line, a
/// --config file or a default. All ranks of a job must have the same. Leaves out --config itself, since only
/// the file's content counts, and --verbose, which may differ between ranks.
Facts settled_options(const char* subcommand, const OptionList& options, const OptionList& program);

}  // namespace ringsplat::app
