#pragma once
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "options/option_list.hpp"
#include "options/options.hpp"
#include "ringsplat/base/fact.hpp"

namespace CLI {
class FormatterBase;
}

namespace ringsplat::app {

/// A text to print on stdout, and nothing else to do (--help, --version, --man).
struct Say {
  std::string text;
};

/// What to do; nothing when the command line was wrong.
using Command = std::variant<std::monostate, Say, RenderOptions, ServeOptions, InfoOptions, CompareOptions,
                             SynthOptions, PyramidOptions, ReferenceOptions>;

struct CommandLine {
  Command command;
  bool verbose = false;
  Facts options;                   ///< what the user said (settled_options)
  std::vector<std::string> notes;  ///< what the user should know of it, however it ends
  std::string error;               ///< one line with a hint, or empty
};

/// Reads the command line and the --config file it names. Does not throw: a rank cannot report an error
/// before it knows whether it is rank 0. `mpi` names the library of the ranks, for --version.
CommandLine parse_command_line(int argc, const char* const* argv, const std::string& mpi = {});

/// Completes the options of a subcommand once they are read, and returns them. Throws InputError when
/// something is missing.
using Settle = std::function<Command(const OptionList& list)>;

struct Subcommand {
  const char* name;
  const char* description;
  const char* config;    ///< what lines of a --config file may be
  const char* examples;  ///< command lines, indented
  const char* everyday;  ///< the options that --help shows, with blanks between; empty: all
  /// They are bound to targets that last as long as what is returned.
  Settle (*add_options)(OptionList& list);
};

/// A subcommand and its options, bound to their targets.
struct BoundSubcommand {
  const Subcommand* what;
  OptionList options;
  Settle settle;
};

/// In the order of --help.
std::span<const Subcommand> subcommands();

/// The settings of a subcommand and of the program, option by option, whether from the command line, a
/// --config file or a default. All ranks of a job must have the same. Leaves out --config itself, since only
/// the file's content counts, and --verbose, which may differ between ranks.
Facts settled_options(const char* subcommand, const OptionList& options, const OptionList& program);

// About the program as a whole, for --help and the manual page.
inline constexpr char summary[] = "ringsplat renders volumes on one process or on many MPI ranks";
inline constexpr char description[] =  // continues the summary
    "GPs hold slices and make splats,\n"
    "Renderers own parts of the screen, tokens keep the slices in order.";
inline constexpr char program_examples[] = R"(  ringsplat render head.nrrd -o head.png
  mpirun -n 6 ringsplat render head.nrrd -o head.png --gps 4 --renderers 2 --tf mr-surface --azimuth 30
  ringsplat info head_256x256x128_uint8.raw
  ringsplat render --help)";
inline constexpr char config_help[] =  // {}: a line of such a file
    "Any option can be put into a TOML file and read with --config FILE: a line such as {}.\n"
    "What the command line says comes first. --verbose says more, on every rank.";
inline constexpr char exit_codes[] =
    "0 done, 1 a comparison failed or --max-error is broken, 2 wrong usage or bad input, "
    "3 a failure while running.";

/// Writes --help and --help-all. Where there are everyday options --help shows these alone, in few words, so
/// that they fit one screen.
std::shared_ptr<CLI::FormatterBase> help_formatter(const std::string& everyday);

/// The manual page, section 1, as roff for man(7): all options of the program and its subcommands, and the
/// rules between them (contradictions.hpp).
std::string man_page(const OptionList& program, std::span<const BoundSubcommand> subcommands);

/// The shells that completion_script() knows, as --help shows them.
inline constexpr const char* completion_shells = "bash|zsh|fish";

/// A script with which that shell asks the program how a command line may go on. Throws InputError for a
/// shell that it does not know.
std::string completion_script(const std::string& shell);

/// How a command line may go on, of which `words` are the ones behind the program's name up to the cursor: a
/// line for each word that may stand in the last one's place, with what it means behind a tab. The line
/// ":files" stands for those that the shell finds.
std::string completions(const OptionList& program, std::span<const BoundSubcommand> subcommands, Words words);

}  // namespace ringsplat::app
