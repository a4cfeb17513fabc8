#pragma once
#include <CLI/CLI.hpp>
#include <span>
#include <string>
#include <variant>

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
  void (*add_options)(CLI::App& app, AllOptions& options);
  /// Completes the options once `app` is parsed, and returns them. Throws InputError when something is
  /// missing.
  Command (*settle)(const CLI::App& app, AllOptions& options);
};

/// What all pictures have in common: completes render's options once `app` is parsed. Throws InputError when
/// they do not fit together.
void settle_picture(const CLI::App& app, RenderOptions& o);

/// In the order of --help.
std::span<const Subcommand> subcommands();

}  // namespace ringsplat::app
