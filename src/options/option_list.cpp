#include "options/option_list.hpp"

#include <array>

#include "options/option_values.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

/// What a flag's word says: flags of a file have one.
bool is_set(const std::string& word, const std::string& option) {
  constexpr std::array<std::string_view, 5> set{"true", "on", "yes", "enable", "1"},
      clear{"false", "off", "no", "disable", "0"};
  if (std::find(set.begin(), set.end(), word) != set.end()) return true;
  if (std::find(clear.begin(), clear.end(), word) == clear.end()) refuse_choice(option, word, "true|false");
  return false;
}

}  // namespace

std::string described_bounds(bool whole, const std::string& least, const std::string& most) {
  const std::string number = whole ? "a whole number" : "a number";
  if (!least.empty() && !most.empty()) return fmt::format("{} from {} to {}", number, least, most);
  if (!least.empty()) return fmt::format("{} of at least {}", number, least);
  return most.empty() ? number : fmt::format("{} of at most {}", number, most);
}

void refuse_word(const std::string& option, const std::string& text, const std::string& wanted) {
  throw InputError(fmt::format("{} cannot be '{}'", option, text), wanted);
}

void refuse_choice(const std::string& option, const std::string& text, const std::string& words) {
  refuse_word(option, text, fmt::format("use {} {}", option, words));
}

Reader flag(bool& target, bool meaning) {
  const auto read = [&target, meaning](const Words& words, const std::string& option) {
    if (is_set(words.back(), option)) target = meaning;
  };
  return {"", read, 0};
}

void OptionList::Below::operator+=(std::initializer_list<OptionRow> rows) {
  for (const OptionRow& row : rows) {
    Option option{.heading = heading,
                  .form = row.form != nullptr ? row.form : row.reader.form,
                  .help = row.help,
                  .reader = row.reader,
                  .mark = row.mark};
    if (row.fallback != nullptr)
      option.fallback = *row.fallback == *initial ? row.reader.initial : row.fallback;
    for (const auto name : split(row.names, ",")) option.names.emplace_back(name);
    list.push_back(std::move(option));
  }
}

}  // namespace ringsplat::app
