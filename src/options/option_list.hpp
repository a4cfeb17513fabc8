#pragma once
#include <algorithm>
#include <concepts>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/text.hpp"

/// Options as tables: a row says all about one option and what reads its words.
namespace ringsplat::app {

using Words = std::vector<std::string>;

/// Makes a value of an option's words, for a target that must outlive the reading.
struct Reader {
  std::string form = {};  ///< what --help shows for the value where the row does not say
  /// Throws InputError that names the option.
  std::function<void(const Words& words, const std::string& option)> read = {};
  int words = 1;             ///< that follow the name; 0: a flag, whose word is true or false
  bool repeats = false;      ///< it may be given several times
  std::string initial = {};  ///< the target's value before anything is read, as text
};

/// A row's fallback when --help should show the target's initial value.
inline constexpr char initial[] = "";

enum class Mark {
  none,
  required,
  of_program,  ///< only the program has it: it names what else is an argument, or writes further files
  of_splats,   ///< it has a meaning for this engine only
  of_sheets
};

struct OptionRow {
  const char* names;     ///< separated by commas; a name without dashes is a positional argument
  const char* form;      ///< what --help shows for the value; null: the reader's
  const char* fallback;  ///< what --help shows as the default; null: nothing
  const char* help;      ///< no full stop
  Reader reader;
  Mark mark = Mark::none;
};

/// An option, and the words that were given for it.
struct Option {
  Words names = {};  ///< with their dashes, of which an argument's name has none
  std::string heading, form;
  std::string fallback = {};  ///< empty: there is none to show
  std::string help;
  Reader reader;
  Mark mark = Mark::none;
  Words given = {};

  /// The long one.
  const std::string& name() const { return names.back(); }
  bool has_name(std::string_view name) const { return std::ranges::find(names, name) != names.end(); }
  bool is_positional() const { return !name().starts_with('-'); }
  bool is_flag() const { return reader.words == 0; }
  bool is_given() const { return !given.empty(); }
};

/// A subcommand's options, in the order of --help.
struct OptionList : std::vector<Option> {
  /// A heading of --help, below which rows are added: list.below("View") += {row, row}.
  struct Below {
    OptionList& list;
    const char* heading;
    void operator+=(std::initializer_list<OptionRow> rows);
  };
  Below below(const char* heading) { return {*this, heading}; }
  void leave_out(Mark mark) {
    std::erase_if(*this, [mark](const Option& option) { return option.mark == mark; });
  }

  /// The option of this name, or null.
  const Option* find(std::string_view name) const {
    const auto found = std::find_if(begin(), end(), [name](const Option& o) { return o.has_name(name); });
    return found == end() ? nullptr : &*found;
  }
  /// False when there is no such option, too.
  bool is_given(std::string_view name) const {
    const Option* const option = find(name);
    return option != nullptr && option->is_given();
  }
  /// Passes what was given to its targets, in the list's order. Throws InputError.
  void read() const {
    for (const Option& option : *this)
      if (option.is_given()) option.reader.read(option.given, option.name());
  }
};

/// What an optional may hold; of another type the type itself.
template <class T>
using ValueOf = typename decltype(std::optional(std::declval<T>()))::value_type;

/// What a number may be, ends included.
template <class T>
struct Bounds {
  std::optional<T> least = {}, most = {};
  bool hold(T value) const { return (!least || value >= *least) && (!most || value <= *most); }
};

/// "a whole number from 1 to 16"; an end that is missing is an empty text.
std::string described_bounds(bool whole, const std::string& least, const std::string& most);
/// Throws InputError: `text` is not what is `wanted`.
[[noreturn]] void refuse_word(const std::string& option, const std::string& text, const std::string& wanted);

/// The text as a number. Throws InputError that says which numbers are right.
template <class T>
T read_number(const std::string& text, const std::string& option, const Bounds<T>& bounds = {}) {
  const auto shown = [](const std::optional<T>& end) {
    return end ? fmt::format("{}", *end) : std::string();
  };
  const auto number = detail::number_in<T>(text);
  if (!number || !bounds.hold(*number))
    refuse_word(option, text,
                "give " + described_bounds(std::is_integral_v<T>, shown(bounds.least), shown(bounds.most)));
  return *number;
}

/// One word for `take(text, option)`, which may throw InputError.
inline Reader text(std::function<void(const std::string& text, const std::string& option)> take) {
  return {"TEXT", [take](const Words& words, const std::string& option) { take(words.front(), option); }};
}

/// An option without a value, which gives `target` this one.
Reader flag(bool& target, bool meaning = true);
/// Texts of an option that may be given several times.
inline Reader values(std::vector<std::string>& target) {
  return {"TEXT", [&target](const Words& words, const std::string&) { target = words; }, 1, true};
}

/// A number within bounds.
template <class T>
requires std::is_arithmetic_v<ValueOf<T>> Reader value(T& target, const Bounds<ValueOf<T>>& bounds = {}) {
  using Number = ValueOf<T>;
  Reader reader = text([&target, bounds](const std::string& word, const std::string& option) {
    target = read_number<Number>(word, option, bounds);
  });
  reader.form = std::is_floating_point_v<Number> ? "FLOAT" : std::is_signed_v<Number> ? "INT" : "UINT";
  if constexpr (std::same_as<T, Number>) reader.initial = fmt::format("{}", target);
  return reader;
}

/// A text that `parse(text, option)` turns into the value.
template <class Target, class Parse>
Reader parsed(Target& target, Parse parse) {
  return text(
      [&target, parse](const std::string& word, const std::string& option) { target = parse(word, option); });
}

/// A text as it is.
inline Reader value(std::string& target) {
  Reader reader = parsed(target, [](const std::string& text, const std::string&) { return text; });
  reader.initial = target;
  return reader;
}

/// The words of a choice and their meanings.
template <class T>
using Choices = std::vector<std::pair<std::string, T>>;

/// Values by their names.
template <class T>
Choices<T> named(std::initializer_list<T> values) {
  return detail::mapped(values, [](T value) { return std::pair<std::string, T>(name(value), value); });
}

/// Throws InputError that lists the words.
[[noreturn]] void refuse_choice(const std::string& option, const std::string& text, const std::string& words);

template <class T>
std::string words_of(const Choices<T>& choices) {
  return detail::joined(choices, "|", &Choices<T>::value_type::first);
}

/// What a word means. Throws InputError that lists the words.
template <class T>
T chosen(const Choices<T>& choices, const std::string& given, const std::string& option) {
  for (const auto& [word, meaning] : choices)
    if (word == given) return meaning;
  refuse_choice(option, given, words_of(choices));
}

/// One of a few words.
template <class T>
Reader choice(T& target, const Choices<ValueOf<T>>& choices) {
  Reader reader = text([&target, choices](const std::string& given, const std::string& option) {
    target = chosen(choices, given, option);
  });
  reader.form = words_of(choices);
  for (const auto& [word, meaning] : choices)
    if (reader.initial.empty() && target == meaning) reader.initial = word;
  return reader;
}

}  // namespace ringsplat::app
