#include "options/settled_options.hpp"

#include <fmt/format.h>

#include <charconv>
#include <limits>
#include <sstream>
#include <string>

namespace ringsplat::app {
namespace {

/// Writes "1", "1.0" and "1e0" alike. Integers that a double cannot hold stay as they are.
std::string plain(const std::string& word) {
  double number = 0;
  const auto* end = word.data() + word.size();
  const auto [parsed, error] = std::from_chars(word.data() + (word.starts_with('+') ? 1 : 0), end, number);
  const bool exact = word.size() <= std::numeric_limits<double>::digits10;
  return error == std::errc{} && parsed == end && exact ? fmt::format("{}", number + 0) : word;
}

std::string plain_words(const std::string& text) {
  std::istringstream words(text);
  std::string all, word;
  while (words >> word) all.append(all.empty() ? "" : " ").append(plain(word));
  return all;
}

/// True for names of files, which are compared letter by letter.
bool is_text(const CLI::Option& option) {
  return option.get_positional() || option.get_type_name().find("FILE") != std::string::npos;
}

std::string value_of(const CLI::Option& option) {
  const bool flag = option.get_items_expected_max() == 0;
  std::string value;
  if (option.count() == 0)
    value = flag ? "false" : option.get_default_str();
  else
    for (const auto& word : option.results()) value += (value.empty() ? "" : " ") + word;
  if (!is_text(option)) value = plain_words(value);
  return value.empty() ? "(none)" : value;
}

std::string name_of(const CLI::Option& option) {
  if (option.get_positional()) return option.get_type_name();
  return option.get_lnames().empty() ? option.get_name() : "--" + option.get_lnames().front();
}

bool may_differ(const CLI::App& program, const CLI::Option& option) {
  return &option == program.get_config_ptr() || &option == program.get_help_ptr() ||
         option.check_lname("verbose") || option.check_lname("help") || option.check_lname("help-all");
}

}  // namespace

Facts settled_options(const CLI::App& program) {
  Facts facts;
  const auto add_all = [&](const CLI::App& app) {
    for (const CLI::Option* option : app.get_options())
      if (!may_differ(program, *option)) facts.push_back({name_of(*option), value_of(*option)});
  };
  for (const CLI::App* chosen : program.get_subcommands()) {
    facts.push_back({"subcommand", chosen->get_name()});
    add_all(*chosen);
  }
  add_all(program);
  return facts;
}

}  // namespace ringsplat::app
