#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <iterator>
#include <sstream>
#include <vector>

#include "base/text.hpp"
#include "command_line/command_line.hpp"
#include "options/contradictions.hpp"
#include "options/option_values.hpp"

namespace ringsplat::app {
namespace {

constexpr std::size_t screen_width = 100;

/// Lines of at most `width` characters.
std::string wrapped(const std::string& text, std::size_t width) {
  std::string all;
  std::size_t used = 0;
  for (const std::string& word : detail::words_of(text)) {
    const bool fits = used + 1 + word.size() <= width;
    if (!all.empty()) all += fits ? " " : "\n";
    used = word.size() + (all.empty() || !fits ? 0 : used + 1);
    all += word;
  }
  return all;
}

class HelpFormatter : public CLI::Formatter {
 public:
  explicit HelpFormatter(const std::string& everyday) : everyday_(detail::words_of(everyday)) {
    column_width(column);
  }
  /// "--zoom NUMBER [1]": CLI11's own line glues the default to the type and counts values.
  std::string make_option_opts(const CLI::Option* option) const override {
    std::string text = option->get_type_name().empty() ? "" : " " + option->get_type_name();
    if (!option->get_default_str().empty()) text += " [" + option->get_default_str() + "]";
    return option->get_required() && !option->get_positional() ? text + " (required)" : text;
  }

  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    if (mode != CLI::AppFormatMode::Normal || everyday_.empty())
      return CLI::Formatter::make_help(app, name, mode);
    std::string text = make_description(app) + make_usage(app, name) + "\n";
    for (const CLI::Option* option : app->get_options())
      if (option->get_positional()) text += everyday_entry(*option);
    text += everyday_groups(*app);
    const std::string footer = app->get_footer();
    return text + "\n" + footer.substr(std::min(footer.size(), footer.find("Examples:"))) + "\n";
  }

 private:
  static constexpr std::size_t column = 34;  ///< where an option's help begins
  std::string everyday_entry(const CLI::Option& option) const {
    std::ostringstream entry;
    const std::string help = option.get_description();
    const std::string without_details = help.substr(0, help.find(';'));
    CLI::detail::format_help(entry,
                             make_option_name(&option, option.get_positional()) + make_option_opts(&option),
                             wrapped(without_details, screen_width - column), column);
    return entry.str();
  }

  /// Headings that have more options than are shown say so; headings of which none is shown come last, by
  /// name.
  std::string everyday_groups(const CLI::App& app) const {
    const auto is_everyday = [&](const CLI::Option& option) {
      return std::ranges::any_of(everyday_, [&](const std::string& name) { return option.check_name(name); });
    };
    std::string text;
    std::vector<std::string> others;
    for (const std::string& group : app.get_groups()) {
      std::string entries;
      bool all = true;
      for (const CLI::Option* option : app.get_options()) {
        const bool help = option == app.get_help_ptr() || option == app.get_help_all_ptr();
        if (help || option->get_positional() || option->get_group() != group) continue;
        if (is_everyday(*option)) entries += everyday_entry(*option);
        all = all && is_everyday(*option);
      }
      if (!entries.empty())
        text += fmt::format("\n{}{}:\n{}", group, all ? "" : " (more with --help-all)", entries);
      else if (!all && !group.empty())
        others.push_back(group.substr(0, group.find(" (")));
    }
    const std::string rest =
        fmt::format("--help-all shows all options in full, also those of {}.", joined(others, ", "));
    return text + "\n" + wrapped(rest, screen_width) + "\n";
  }

  std::vector<std::string> everyday_;
};

/// Escapes text for roff: dashes stay copyable, and no line looks like a request.
std::string roff(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    const bool begins_line = safe.empty() || safe.back() == '\n';
    if (begins_line && (c == '.' || c == '\'')) safe += "\\&";
    if (c == '-')
      safe += "\\-";
    else if (c == '\\')
      safe += "\\e";
    else
      safe += c;
  }
  return safe;
}

std::string bold(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + roff(text) + "\\fR"; }

std::string section(std::string title) {
  for (char& c : title) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return ".SH " + roff(title) + "\n";
}

/// Command lines as they are typed.
std::string example(const std::string& lines) { return ".PP\n.nf\n" + roff(lines) + "\n.fi\n"; }

/// "-o, --output FILE [default]".
std::string usage_of(const Option& option) {
  auto names = detail::mapped(option.names, bold);
  if (!option.form.empty()) names.back().append(" ").append(italic(option.form));
  std::string usage = option.is_positional() ? italic(option.form) : joined(names, ", ");
  if (!option.fallback.empty()) usage += " [" + roff(option.fallback) + "]";
  return option.mark == Mark::required && !option.is_positional() ? usage + " (required)" : usage;
}

/// The entries of `all` that the list has, as users type them.
std::vector<std::string> names_of(const std::vector<Which>& all, const OptionList& list) {
  std::vector<std::string> names;
  for (const Which& which : all) {
    const Option* const option = list.find(which.option);
    if (option == nullptr) continue;
    names.push_back(option->is_positional() ? option->form : which.option);
    if (which.value) names.back().append(" ").append(*which.value);
  }
  return names;
}

bool is_among(const Option& option, const std::vector<Which>& all) {
  return std::ranges::any_of(all, [&](const Which& which) { return !which.value && means(which, option); });
}

/// The rules for an option: "Not with --orbit. Needs --mesh."
std::string relations_of(const Option& option, const OptionList& list) {
  std::vector<std::string> not_with;
  std::string needs;
  for (const Rule& rule : rules()) {
    const bool first = is_among(option, rule.options);
    if (rule.relation == Relation::excludes && first)
      std::ranges::copy(names_of(rule.others, list), std::back_inserter(not_with));
    if (rule.relation == Relation::excludes && is_among(option, rule.others))
      std::ranges::copy(names_of(rule.options, list), std::back_inserter(not_with));
    const auto needed = names_of(rule.others, list);
    if (rule.relation == Relation::needs && first && !needed.empty())
      needs += fmt::format(" Needs {}.", joined(needed, " or "));
  }
  return (not_with.empty() ? "" : fmt::format(" Not with {}.", joined(not_with, ", "))) + needs;
}

std::string paragraph_of(const Option& option, const OptionList& list) {
  std::string help = option.help;
  if (!help.ends_with('.')) help += ".";
  return fmt::format(".TP\n{}\n{}\n", usage_of(option), roff(help + relations_of(option, list)));
}

/// Positional arguments, then the options below their headings. The group of --help, which all subcommands
/// have, needs no heading.
std::string options_of(const OptionList& list) {
  std::string text;
  std::vector<std::string> headings;
  for (const Option& option : list) {
    if (option.is_positional()) text += paragraph_of(option, list);
    if (!option.is_positional() && std::ranges::find(headings, option.heading) == headings.end())
      headings.push_back(option.heading);
  }
  for (const std::string& heading : headings) {
    if (heading != "Options") text += ".SS " + roff(heading) + "\n";
    for (const Option& option : list)
      if (!option.is_positional() && option.heading == heading) text += paragraph_of(option, list);
  }
  return text;
}

std::string synopsis_of(const BoundSubcommand& subcommand) {
  std::string line = bold(std::string("ringsplat ") + subcommand.what->name) + " [" + italic("OPTIONS") + "]";
  for (const Option& option : subcommand.options)
    if (option.is_positional()) {
      const std::string name = italic(option.form);
      line += option.mark == Mark::required ? " " + name : " [" + name + "]";
    }
  return line + "\n.br\n";
}

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_formatter(const std::string& everyday) {
  return std::make_shared<HelpFormatter>(everyday);
}

std::string man_page(const OptionList& program, std::span<const BoundSubcommand> subcommands) {
  std::string text = ".TH RINGSPLAT 1 \"\" \"ringsplat " RINGSPLAT_VERSION "\" \"User Commands\"\n";
  text += ".nh\n.ad l\n";  // options are not hyphenated
  // The line that apropos searches: a name and what it does.
  const std::string said = summary, name = said.substr(0, said.find(' '));
  text += section("Name") + roff(name) + " \\- " + roff(said.substr(name.size() + 1)) + "\n";
  text += section("Synopsis");
  for (const auto& subcommand : subcommands) text += synopsis_of(subcommand);
  text += section("Description") + roff(summary) + ": " + roff(description) + "\n";
  text += section("Options") + options_of(program);
  for (const auto& [what, options, settle] : subcommands) {
    text += section(fmt::format("ringsplat {}", what->name));
    text += roff(what->description) + std::string(".\n");
    text += options_of(options);
    text += ".SS Examples\n" + example(what->examples);
  }
  text += section("Configuration files");
  text += roff(fmt::format(config_help, subcommands.front().what->config)) + "\n";
  text += section("Exit status") + roff(exit_codes) + "\n";
  return text + section("Examples") + example(program_examples);
}

}  // namespace ringsplat::app
