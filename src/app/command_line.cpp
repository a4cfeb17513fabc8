#include "app/command_line.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/version_text.hpp"
#include "options/completion.hpp"
#include "options/contradictions.hpp"
#include "options/former_names.hpp"
#include "options/help.hpp"
#include "options/likely_option.hpp"
#include "options/man_page.hpp"
#include "options/program_texts.hpp"
#include "options/settled_options.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

constexpr ProgramTexts texts{
    .summary = "ringsplat renders volumes on one process or on many MPI ranks",
    .description =
        "GPs hold slices and make splats,\n"
        "Renderers own parts of the screen, tokens keep the slices in order.",
    .examples = R"(  ringsplat render head.nrrd -o head.png
  mpirun -n 6 ringsplat render head.nrrd -o head.png --gps 4 --renderers 2 --tf mr-surface --azimuth 30
  ringsplat info head_256x256x128_uint8.raw
  ringsplat render --help)",
    .config =
        "Any option can be put into a TOML file and read with --config FILE: a line such as {}.\n"
        "What the command line says comes first. --verbose says more, on every rank.",
    .exit_codes =
        "0 done, 1 a comparison failed or --max-error is broken, 2 wrong usage or bad input, "
        "3 a failure while running."};

/// Thrown by --man.
struct CallForMan {};

/// Thrown by --completion with the script.
struct CallForCompletion {
  std::string script;
};

/// TOML whose keys outside of any [section] are options of the subcommand on the command line.
class SubcommandToml : public CLI::ConfigTOML {
 public:
  SubcommandToml(const CLI::App& program, FormerNames& former) : program_(program), former_(former) {}

  std::vector<CLI::ConfigItem> from_config(std::istream& in) const override {
    auto read = CLI::ConfigTOML::from_config(in);
    const auto chosen = program_.get_subcommands();
    for (auto& item : read) {
      item.name = former_.renamed(item.name);
      if (item.parents.empty() && !chosen.empty() &&
          program_.get_option_no_throw("--" + item.name) == nullptr)
        item.parents = {chosen.front()->get_name()};
    }
    return read;
  }

 private:
  const CLI::App& program_;
  FormerNames& former_;
};

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  while (text.ends_with(' ') || text.ends_with('.')) text.pop_back();
  return text;
}

std::string with_hint(const std::string& problem, const std::string& hint) {
  return one_line(problem) + "; hint: " + hint;
}

/// All names of a subcommand's options.
std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

/// True for an error about extra words. Without a subcommand CLI11 says that one is missing, though it may be
/// misspelt.
bool is_about_extras(const CLI::App& program, const CLI::ParseError& error) {
  return dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr ||
         (program.get_subcommands().empty() && program.remaining_size(true) > 0);
}

/// The hint: the help of the parsed subcommand, or an option that the unknown one may mean.
std::string hint_for(const CLI::App& program, const CLI::ParseError& error) {
  const auto chosen = program.get_subcommands();
  const std::string help =
      chosen.empty() ? "ringsplat --help shows the subcommands"
                     : fmt::format("ringsplat {} --help shows the options", chosen.front()->get_name());
  if (!is_about_extras(program, error)) return help;
  for (const auto& extra : program.remaining(true)) {
    auto known = chosen.empty() ? std::vector<std::string>() : option_names(*chosen.front());
    if (!extra.starts_with("-") && chosen.empty())
      for (const auto* subcommand : program.get_subcommands({})) known.push_back(subcommand->get_name());
    const std::string likely = likely_option(extra.substr(0, extra.find('=')), known);
    if (!likely.empty()) return fmt::format("{} {}", likely, help);
  }
  return help;
}

/// The error in CLI11's words where they are clear, else in ours.
std::string problem_of(const CLI::App& program, const CLI::ParseError& error) {
  if (dynamic_cast<const CLI::ConfigError*>(&error) != nullptr)
    return fmt::format("the --config file has a key that is no option: {}", error.what());
  if (dynamic_cast<const CLI::FileError*>(&error) != nullptr)
    return fmt::format("the --config file cannot be read: {}", error.what());
  if (is_about_extras(program, error)) {
    std::string extras;
    for (const auto& extra : program.remaining(true)) extras += (extras.empty() ? "" : " ") + extra;
    return fmt::format("'{}' is not expected here", extras);
  }
  return error.what();
}

void add_program_options(CLI::App& program, bool& verbose, FormerNames& former) {
  program.set_version_flag("--version", version_text);
  program.set_help_flag("-h,--help", "Print this help");
  program.set_help_all_flag("--help-all", "Print the help of all options");
  program
      .add_flag_callback(
          "--man", [] { throw CallForMan(); }, "Print the manual page, which man -l - shows")
      ->configurable(false);
  program
      .add_option_function<std::string>(
          "--completion",
          [&program](const std::string& shell) { throw CallForCompletion{completion(program, shell)}; },
          "Print the script with which this shell completes command lines")
      ->type_name(completion_shells)
      ->configurable(false);
  program.add_flag("--verbose", verbose, "Say more, on every rank");
  program.set_config("--config", "", "A TOML file with options")->type_name("FILE");
  program.config_formatter(std::make_shared<SubcommandToml>(program, former));
  program.allow_config_extras(CLI::config_extras_mode::error);
}

void add_subcommands(CLI::App& program, AllOptions& options) {
  for (const Subcommand& subcommand : subcommands()) {
    auto* app = program.add_subcommand(subcommand.name, subcommand.description);
    subcommand.add_options(*app, options);
    app->footer(fmt::format(fmt::runtime(texts.config), subcommand.config) + "\n\nExamples:\n" +
                subcommand.examples);
  }
}

void prepare(CLI::App& program, bool& verbose, FormerNames& former, AllOptions& options) {
  program.formatter(std::make_shared<HelpFormatter>());
  program.footer(fmt::format("Examples:\n{}\n\nExit codes: {}", texts.examples, texts.exit_codes));
  program.fallthrough();
  program.require_subcommand(1);
  add_program_options(program, verbose, former);
  add_subcommands(program, options);
}

/// The command of a program parsed without an error.
Command command_of(const CLI::App& program, AllOptions& options) {
  refuse_contradictions(program);
  const CLI::App& chosen = *program.get_subcommands().front();
  refuse_contradictions(chosen);
  for (const Subcommand& subcommand : subcommands())
    if (chosen.get_name() == subcommand.name) return subcommand.settle(chosen, options);
  return {};
}

}  // namespace

CommandLine parse_command_line(int argc, const char* const* argv) {
  CommandLine line;
  AllOptions options;
  CLI::App program(fmt::format("{}: {}", texts.summary, texts.description), "ringsplat");
  FormerNames former;
  prepare(program, line.verbose, former, options);
  const auto words = former.renamed(argc, argv);
  std::vector<const char*> with_names_of_today;
  for (const auto& word : words) with_names_of_today.push_back(word.c_str());
  try {
    program.parse(argc, with_names_of_today.data());
    line.options = settled_options(program);
    line.command = command_of(program, options);
  } catch (const CallForMan&) {
    line.command = Say{man_page(program, texts)};
  } catch (const CallForCompletion& e) {
    line.command = Say{e.script};
  } catch (const CLI::CallForHelp&) {
    const auto chosen = program.get_subcommands();
    line.command = Say{chosen.empty() ? program.help() : chosen.front()->help("ringsplat")};
  } catch (const CLI::CallForAllHelp&) {
    const auto chosen = program.get_subcommands();
    constexpr auto all = CLI::AppFormatMode::All;
    line.command = Say{chosen.empty() ? program.help("", all) : chosen.front()->help("ringsplat", all)};
  } catch (const CLI::CallForVersion& e) {
    line.command = Say{std::string(e.what()) + "\n"};
  } catch (const CLI::ParseError& e) {
    line.error = with_hint(problem_of(program, e), hint_for(program, e));
  } catch (const InputError& e) {
    line.error = one_line(e.what());
  } catch (const std::exception& e) {
    line.error = with_hint(fmt::format("an option's value cannot be understood: {}", e.what()),
                           "--help shows the options");
  }
  line.notes = former.notes();
  return line;
}

}  // namespace ringsplat::app
