#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <vector>

#include "base/text.hpp"
#include "command_line/texts.hpp"
#include "options/option_values.hpp"

namespace ringsplat::app {
namespace {

constexpr std::size_t screen_width = 100;

/// Lines of at most so many characters, all but the first indented.
std::string wrapped(const std::string& text, std::size_t indent) {
  std::string all;
  std::size_t used = indent;
  for (const std::string& word : detail::words_of(text)) {
    const bool begins = all.empty(), fits = used + 1 + word.size() <= screen_width;
    if (!begins) all += fits ? " " : "\n" + std::string(indent, ' ');
    used = (begins ? indent : fits ? used + 1 : indent) + word.size();
    all += word;
  }
  return all;
}

/// What an option does, without the details behind a semicolon.
std::string first_part(const std::string& help) { return help.substr(0, help.find(';')); }

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
    const bool positional = option.get_positional();
    std::string usage = "  " + make_option_name(&option, positional) + make_option_opts(&option);
    if (usage.size() < column)
      usage.resize(column, ' ');
    else
      usage += "\n" + std::string(column, ' ');
    return usage + wrapped(first_part(option.get_description()), column) + "\n";
  }

  /// Headings that have more options than are shown say so; headings of which none is shown come last, by
  /// name.
  std::string everyday_groups(const CLI::App& app) const {
    const auto is_everyday = [&](const CLI::Option& option) {
      return std::any_of(everyday_.begin(), everyday_.end(),
                         [&](const std::string& name) { return option.check_name(name); });
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
      else if (!all)
        others.push_back(group.substr(0, group.find(" (")));
    }
    const std::string rest =
        fmt::format("--help-all shows all options in full, also those of {}.", joined(others, ", "));
    return text + "\n" + wrapped(rest, 0) + "\n";
  }

  std::vector<std::string> everyday_;
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_formatter(const std::string& everyday) {
  return std::make_shared<HelpFormatter>(everyday);
}

}  // namespace ringsplat::app
