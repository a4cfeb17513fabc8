#include "options/option_row.hpp"

#include <algorithm>
#include <array>
#include <string_view>

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

Reader flag_that(std::function<void()> act) {
  return {.form = {},
          .initial = {},
          .read =
              [act](const Words& words, const std::string& option) {
                if (is_set(words.back(), option)) act();
              },
          .words = 0};
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
  return {.form = "TEXT", .initial = {}, .read = [take](const Words& words, const std::string& option) {
            take(words.front(), option);
          }};
}

Reader numbers(int count, std::function<void(const std::vector<double>& numbers)> take) {
  return {.form = "FLOAT",
          .initial = {},
          .read =
              [take](const Words& words, const std::string& option) {
                std::vector<double> all;
                for (const std::string& word : words) all.push_back(read_number<double>(word, option));
                take(all);
              },
          .words = count};
}

Reader flag(bool& target) {
  return flag_that([&target] { target = true; });
}

Reader clearing_flag(bool& target) {
  return flag_that([&target] { target = false; });
}

Reader value(std::string& target) {
  Reader reader = parsed(target, [](const std::string& text, const std::string&) { return text; });
  reader.initial = target;
  return reader;
}

Reader values(std::vector<std::string>& target) {
  return {.form = "TEXT",
          .initial = {},
          .read = [&target](const Words& words, const std::string&) { target = words; },
          .repeats = true};
}

}  // namespace ringsplat::app
