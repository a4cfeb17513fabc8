#include "command_line/settled_options.hpp"

#include <fmt/format.h>

#include <limits>
#include <string>

#include "base/text.hpp"
#include "options/option_values.hpp"

namespace ringsplat::app {
namespace {

/// Writes "1", "1.0" and "1e0" alike. Integers that a double cannot hold stay as they are.
std::string plain(const std::string& word) {
  const auto number = detail::number_in<double>(word);
  const bool exact = word.size() <= std::numeric_limits<double>::digits10;
  return number && exact ? fmt::format("{}", *number + 0) : word;
}

/// True for names of files, which are compared letter by letter.
bool is_text(const Option& option) {
  return option.is_positional() || option.form.find("FILE") != std::string::npos;
}

std::string value_of(const Option& option) {
  std::string value = option.is_flag() ? "false" : option.fallback;
  if (option.is_given()) value = option.is_flag() ? option.given.back() : joined(option.given, " ");
  if (!is_text(option)) {
    auto words = detail::words_of(value);
    for (std::string& word : words) word = plain(word);
    value = joined(words, " ");
  }
  return value.empty() ? "(none)" : value;
}

bool may_differ(const Option& option) {
  return option.has_name("--config") || option.has_name("--verbose") || option.has_name("--help") ||
         option.has_name("--help-all");
}

}  // namespace

Facts settled_options(const char* subcommand, const OptionList& options, const OptionList& program) {
  Facts facts{{"subcommand", subcommand}};
  for (const OptionList* list : {&options, &program})
    for (const Option& option : *list)
      if (!may_differ(option))
        facts.push_back({option.is_positional() ? option.form : option.name(), value_of(option)});
  return facts;
}

}  // namespace ringsplat::app
