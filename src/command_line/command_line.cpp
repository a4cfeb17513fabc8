#include "command_line/command_line.hpp"

#include <CLI/CLI.hpp>

#include "options/contradictions.hpp"

namespace ringsplat::app {
namespace {

/// The former name of --bundle, which still works and is in no help.
constexpr const char* former_bundle = "--slab";

/// TOML whose keys outside of any [section] are options of the subcommand on the command line.
class SubcommandToml : public CLI::ConfigTOML {
 public:
  explicit SubcommandToml(const CLI::App& program) : program_(program) {}

  std::vector<CLI::ConfigItem> from_config(std::istream& in) const override {
    auto read = CLI::ConfigTOML::from_config(in);
    const auto chosen = program_.get_subcommands();
    for (auto& item : read)
      if (item.parents.empty() && !chosen.empty() &&
          program_.get_option_no_throw("--" + item.name) == nullptr)
        item.parents = {chosen.front()->get_name()};
    return read;
  }

 private:
  const CLI::App& program_;
};

std::string with_hint(const std::string& problem, const std::string& hint) {
  std::string line = detail::one_line(problem);
  while (line.ends_with('.')) line.pop_back();
  return line + "; hint: " + hint;
}

/// All names of a subcommand's options.
std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  std::erase(names, former_bundle);
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
  if (is_about_extras(program, error))
    return fmt::format("'{}' is not expected here", joined(program.remaining(true), " "));
  return error.what();
}

/// An option that CLI11 has of itself.
Option described(const CLI::Option& option) {
  Option all{.heading = option.get_group(),
             .form = option.get_type_name(),
             .fallback = option.get_default_str(),
             .help = option.get_description(),
             .reader = {.words = option.get_items_expected_max()},
             .given = option.results()};
  for (const auto& name : option.get_snames()) all.names.push_back("-" + name);
  for (const auto& name : option.get_lnames()) all.names.push_back("--" + name);
  return all;
}

/// Adds an option whose words CLI11 keeps as they are.
void bind(CLI::App& app, const Option& option) {
  const std::string names = joined(option.names, ",");
  CLI::Option* const bound =
      option.is_flag() ? app.add_flag(names)->multi_option_policy(CLI::MultiOptionPolicy::TakeLast)
                       : app.add_option(names)->type_name(option.form)->expected(option.reader.words);
  if (option.reader.repeats) bound->take_all();
  if (option.reader.repeats && option.is_positional()) bound->expected(-1);
  bound->description(option.help)->default_str(option.fallback)->required(option.mark == Mark::required);
  if (!option.is_positional()) bound->group(option.heading);  // CLI11 has a heading for arguments
  if (option.name() == "--bundle") app.add_option(former_bundle)->type_name(option.form)->group("");
}

/// The command line as CLI11 takes it apart, and the options that its words are for.
class Parser {
 public:
  explicit Parser(const std::string& mpi) {
    program_.set_version_flag(
        "--version", "ringsplat " RINGSPLAT_VERSION "\n" + (mpi.empty() ? "without MPI" : "with " + mpi));
    program_.formatter(help_formatter(""));
    program_.footer(fmt::format("Examples:\n{}\n\nExit codes: {}", program_examples, exit_codes));
    program_.fallthrough();
    program_.require_subcommand(1);
    add_program_options();
    add_subcommands();
  }

  CommandLine parse(int argc, const char* const* argv) {
    try {
      if (argc > 1 && argv[1] == std::string_view("--complete"))
        throw CallFor{completions(program_options(), subcommands_, {argv + 2, argv + argc})};
      program_.parse(argc, argv);
      settle();
    } catch (const CallFor& call) {
      line_.command = Say{call.text};
    } catch (const CLI::Success& e) {  // help or version
      std::ostringstream text;
      program_.exit(e, text);
      line_.command = Say{text.str()};
    } catch (const CLI::ParseError& e) {
      line_.error = with_hint(problem_of(program_, e), hint_for(program_, e));
    } catch (const InputError& e) {
      line_.error = detail::one_line(e.what());
    } catch (const std::exception& e) {
      line_.error = with_hint(fmt::format("an option's value cannot be understood: {}", e.what()),
                              "--help shows the options");
    }
    return line_;
  }

 private:
  /// Thrown by options that ask for a text instead of work.
  struct CallFor {
    std::string text;
  };

  void add_program_options() {
    program_.set_help_flag("-h,--help", "Print this help");
    program_.set_help_all_flag("--help-all", "Print the help of all options");
    const auto print_man_page = [this] { throw CallFor{man_page(program_options(), subcommands_)}; };
    program_.add_flag_callback("--man", print_man_page, "Print the manual page, which man -l - shows")
        ->configurable(false);
    const auto print_script = [](const std::string& shell) { throw CallFor{completion_script(shell)}; };
    program_
        .add_option_function<std::string>("--completion", print_script,
                                          "Print the script with which this shell completes command lines")
        ->type_name(completion_shells)
        ->configurable(false);
    program_.add_flag("--verbose", line_.verbose, "Say more, on every rank");
    program_.set_config("--config", "", "A TOML file with options")->type_name("FILE");
    program_.config_formatter(std::make_shared<SubcommandToml>(program_));
    program_.allow_config_extras(CLI::config_extras_mode::error);
  }

  void add_subcommands() {
    for (const Subcommand& subcommand : subcommands()) {
      auto* const app = program_.add_subcommand(subcommand.name, subcommand.description);
      app->formatter(help_formatter(subcommand.everyday));
      app->footer(fmt::format(config_help, subcommand.config) + "\n\nExamples:\n" + subcommand.examples);
      OptionList list;
      Settle settle = subcommand.add_options(list);
      for (const Option& option : list) bind(*app, option);
      list.insert(list.begin(), {described(*app->get_help_ptr()), described(*app->get_help_all_ptr())});
      subcommands_.push_back({&subcommand, std::move(list), std::move(settle)});
    }
  }

  /// The program's own options, with what was given.
  OptionList program_options() const {
    OptionList list;
    for (const CLI::Option* option : program_.get_options()) list.push_back(described(*option));
    return list;
  }

  /// Reads what was given. Throws InputError.
  void settle() {
    const CLI::App& app = *program_.get_subcommands().front();
    const auto chosen = std::find_if(subcommands_.begin(), subcommands_.end(),
                                     [&](const auto& one) { return app.get_name() == one.what->name; });
    OptionList& options = chosen->options;
    for (Option& option : options) {
      option.given = app.get_option(option.name())->results();
      if (option.name() != "--bundle" || app.count(former_bundle) == 0) continue;
      line_.notes = {"--slab is now called --bundle; the old name goes with a later version"};
      if (!option.is_given()) option.given = app.get_option(former_bundle)->results();
    }
    options.read();
    const OptionList program = program_options();
    line_.options = settled_options(chosen->what->name, options, program);
    refuse_contradictions(program);
    refuse_contradictions(options);
    line_.command = chosen->settle(options);
  }

  CommandLine line_;
  CLI::App program_{fmt::format("{}: {}", summary, description), "ringsplat"};
  std::vector<BoundSubcommand> subcommands_;
};

}  // namespace

CommandLine parse_command_line(int argc, const char* const* argv, const std::string& mpi) {
  return Parser(mpi).parse(argc, argv);
}

}  // namespace ringsplat::app
