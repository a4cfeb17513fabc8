#include "options/option_list.hpp"

#include <algorithm>
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

Reader text(std::function<void(const std::string& text, const std::string& option)> take) {
  return {"TEXT", [take](const Words& words, const std::string& option) { take(words.front(), option); }};
}

Reader flag(bool& target, bool meaning) {
  const auto read = [&target, meaning](const Words& words, const std::string& option) {
    if (is_set(words.back(), option)) target = meaning;
  };
  return {"", read, 0};
}

Reader value(std::string& target) {
  Reader reader = parsed(target, [](const std::string& text, const std::string&) { return text; });
  reader.initial = target;
  return reader;
}

Reader values(std::vector<std::string>& target) {
  return {"TEXT", [&target](const Words& words, const std::string&) { target = words; }, 1, true};
}

bool Option::has_name(std::string_view name) const { return std::ranges::find(names, name) != names.end(); }

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

const Option* OptionList::find(std::string_view name) const {
  const auto found = std::find_if(begin(), end(), [name](const Option& o) { return o.has_name(name); });
  return found == end() ? nullptr : &*found;
}

bool OptionList::is_given(std::string_view name) const {
  const Option* const option = find(name);
  return option != nullptr && option->is_given();
}

void OptionList::read() const {
  for (const Option& option : *this)
    if (option.is_given()) option.reader.read(option.given, option.name());
}

}  // namespace ringsplat::app
