#pragma once
#include <CLI/CLI.hpp>
#include <span>
#include <vector>

/// What options have to do with each other: a table by which command lines are checked and of which the
/// manual page tells.
namespace ringsplat::app {

/// Options of a subcommand, or values of them.
struct Which {
  const char* option = nullptr;   ///< null: every option …
  const char* heading = nullptr;  ///< … or every option below this heading of --help
  const char* value = nullptr;    ///< null: whatever it is
};

enum class Relation {
  excludes,  ///< none of `others` may be given with it
  needs,     ///< one of `others` must be given with it, where the subcommand has one of them
  refused    ///< it may not be given
};

struct Rule {
  std::vector<Which> options;  ///< each of them …
  Relation relation;
  std::vector<Which> others;
  const char* way_out;            ///< with {0} for the option
  const char* problem = nullptr;  ///< with {0} for the option and {1} for the others; null: the usual words
};

/// In the order in which they are applied: the first one that a command line breaks is told.
std::span<const Rule> rules();

/// Whether `which` means the option, whatever its value.
bool means(const Which& which, const CLI::Option& option);
/// Whether a subcommand has an option that `which` means.
bool has(const CLI::App& app, const Which& which);

/// Throws InputError when a parsed subcommand's options break a rule, with the way out.
void refuse_contradictions(const CLI::App& app);

}  // namespace ringsplat::app
