#include "options/man_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <vector>

#include "options/contradictions.hpp"
#include "options/option_values.hpp"
#include "options/subcommands.hpp"

namespace ringsplat::app {
namespace {

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

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

std::string section(const std::string& title) { return ".SH " + roff(upper(title)) + "\n"; }

/// Command lines as they are typed.
std::string example(const std::string& lines) { return ".PP\n.nf\n" + roff(lines) + "\n.fi\n"; }

/// "-o, --output FILE [default]".
std::string usage_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const auto& name : option.get_snames()) names.push_back(bold("-" + name));
  for (const auto& name : option.get_lnames()) names.push_back(bold("--" + name));
  if (!option.get_positional() && !option.get_type_name().empty())
    names.back() += " " + italic(option.get_type_name());
  std::string usage = option.get_positional() ? italic(option.get_type_name()) : joined(names, ", ");
  if (!option.get_default_str().empty()) usage += " [" + roff(option.get_default_str()) + "]";
  return option.get_required() && !option.get_positional() ? usage + " (required)" : usage;
}

/// The entries of `all` that the subcommand has, as users type them.
std::vector<std::string> names_of(const std::vector<Which>& all, const CLI::App& app) {
  std::vector<std::string> names;
  for (const Which& which : all) {
    if (which.option == nullptr || !has(app, which)) continue;
    const CLI::Option& option = *app.get_option(which.option);
    names.push_back(option.get_positional() ? option.get_type_name() : which.option);
    if (which.value != nullptr) names.back().append(" ").append(which.value);
  }
  return names;
}

bool is_among(const CLI::Option& option, const std::vector<Which>& all) {
  return std::any_of(all.begin(), all.end(),
                     [&](const Which& which) { return which.value == nullptr && means(which, option); });
}

void append(std::vector<std::string>& all, const std::vector<std::string>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

/// The rules for an option: "Not with --orbit. Needs --mesh."
std::string relations_of(const CLI::Option& option, const CLI::App& app) {
  std::vector<std::string> not_with;
  std::string needs;
  for (const Rule& rule : rules()) {
    const bool first = is_among(option, rule.options);
    if (rule.relation == Relation::excludes && first) append(not_with, names_of(rule.others, app));
    if (rule.relation == Relation::excludes && is_among(option, rule.others))
      append(not_with, names_of(rule.options, app));
    const auto needed = names_of(rule.others, app);
    if (rule.relation == Relation::needs && first && !needed.empty())
      needs += fmt::format(" Needs {}.", joined(needed, " or "));
  }
  return (not_with.empty() ? "" : fmt::format(" Not with {}.", joined(not_with, ", "))) + needs;
}

std::string paragraph_of(const CLI::Option& option, const CLI::App& app) {
  std::string help = option.get_description();
  if (!help.ends_with('.')) help += ".";
  return fmt::format(".TP\n{}\n{}\n", usage_of(option), roff(help + relations_of(option, app)));
}

/// Positional arguments, then the options below their headings. The group of --help, which all subcommands
/// have, needs no heading.
std::string options_of(const CLI::App& app) {
  std::string text;
  for (const CLI::Option* option : app.get_options())
    if (option->get_positional()) text += paragraph_of(*option, app);
  for (const std::string& group : app.get_groups()) {
    std::string below;
    for (const CLI::Option* option : app.get_options())
      if (!option->get_positional() && option->get_group() == group) below += paragraph_of(*option, app);
    const bool usual = group == "Options";
    text += below.empty() || usual ? below : ".SS " + roff(group) + "\n" + below;
  }
  return text;
}

std::string synopsis_of(const CLI::App& app) {
  std::string line = bold("ringsplat " + app.get_name()) + " [" + italic("OPTIONS") + "]";
  for (const CLI::Option* option : app.get_options())
    if (option->get_positional()) {
      const std::string name = italic(option->get_type_name());
      line += option->get_required() ? " " + name : " [" + name + "]";
    }
  return line + "\n.br\n";
}

/// Turns "ringsplat renders …" into the line that apropos searches.
std::string name_line(const std::string& summary) {
  const auto blank = summary.find(' ');
  return roff(summary.substr(0, blank)) + " \\- " + roff(summary.substr(blank + 1)) + "\n";
}

}  // namespace

std::string man_page(const CLI::App& program, const ProgramTexts& texts) {
  std::string text = ".TH RINGSPLAT 1 \"\" \"ringsplat " RINGSPLAT_VERSION "\" \"User Commands\"\n";
  text += ".nh\n.ad l\n";  // options are not hyphenated
  text += section("Name") + name_line(texts.summary);
  text += section("Synopsis");
  for (const Subcommand& subcommand : subcommands())
    text += synopsis_of(*program.get_subcommand(subcommand.name));
  text += section("Description") + roff(texts.summary) + ": " + roff(texts.description) + "\n";
  text += section("Options") + options_of(program);
  for (const Subcommand& subcommand : subcommands()) {
    text += section(fmt::format("ringsplat {}", subcommand.name));
    text += roff(subcommand.description) + std::string(".\n");
    text += options_of(*program.get_subcommand(subcommand.name));
    text += ".SS Examples\n" + example(subcommand.examples);
  }
  text += section("Configuration files");
  text += roff(fmt::format(fmt::runtime(texts.config), subcommands().front().config)) + "\n";
  text += section("Exit status") + roff(texts.exit_codes) + "\n";
  return text + section("Examples") + example(texts.examples);
}

}  // namespace ringsplat::app
