#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

/// Options as tables: a row says all about one option and where its value goes.
namespace ringsplat::app {

/// Adds a CLI11 option with these names and this help that fills a target.
using Binding = std::function<CLI::Option*(CLI::App& app, const std::string& names, const std::string& help)>;

/// A row's fallback when --help should show the target's initial value.
inline constexpr char initial[] = "";

/// One of the options that fill an `Options`.
template <class Options>
struct OptionRow {
  const char* names;          ///< separated by commas; a name without dashes is a positional argument
  const char* form;           ///< what --help shows for the value; null: the type's name, or a choice's words
  const char* fallback;       ///< what --help shows as the default; null: nothing
  const char* help;           ///< no full stop
  Binding (*bind)(Options&);  ///< binds a member, which must outlive the parsing
  bool required = false;
};

/// Options below one heading of --help, in order.
template <class Options>
struct OptionGroup {
  const char* heading;
  std::span<const OptionRow<Options>> rows;
};

void add_option(CLI::App& app, const char* heading, const char* names, const char* form, const char* fallback,
                const char* help, const Binding& binding, bool required);

/// Adds a group's options, bound to `options`, which must outlive `app`.
template <class Options>
void add_options(CLI::App& app, const OptionGroup<Options>& group, Options& options) {
  for (const auto& row : group.rows)
    add_option(app, group.heading, row.names, row.form, row.fallback, row.help, row.bind(options),
               row.required);
}

/// A value that CLI11 reads by its type.
template <class T>
Binding value(T& target, const CLI::Validator& check = {}) {
  return [&target, check](CLI::App& app, const std::string& names, const std::string& help) {
    return app.add_option(names, target, help)->check(check);
  };
}

/// An option without a value: sets `target`.
Binding flag(bool& target);
/// An option without a value: clears `target`.
Binding clearing_flag(bool& target);

/// A value passed to `take`; `count` numbers when T is a vector.
template <class T>
Binding handed(std::function<void(const T&)> take, int count = 1) {
  return [take, count](CLI::App& app, const std::string& names, const std::string& help) {
    auto* option = app.add_option_function<T>(names, take, help);
    return count == 1 ? option : option->expected(count);
  };
}

/// A text that `parse(text, option)` turns into the value.
template <class Target, class Parse>
Binding parsed(Target& target, Parse parse) {
  return [&target, parse](CLI::App& app, const std::string& names, const std::string& help) {
    const auto take = [&target, parse, names](const std::string& text) { target = parse(text, names); };
    return app.add_option_function<std::string>(names, take, help);
  };
}

template <class T>
struct ChosenType {
  using Type = T;
};
template <class T>
struct ChosenType<std::optional<T>> {
  using Type = T;
};

/// The words of a choice and their meanings.
template <class T>
using Choices = std::vector<std::pair<std::string, T>>;

/// Throws InputError that lists the words.
[[noreturn]] void refuse_choice(const std::string& option, const std::string& text, const std::string& words);

/// One of a few words.
template <class T>
Binding choice(T& target, const Choices<typename ChosenType<T>::Type>& choices) {
  return [&target, choices](CLI::App& app, const std::string& names, const std::string& help) {
    std::string words;
    for (const auto& [word, meaning] : choices) words += (words.empty() ? "" : "|") + word;
    const auto choose = [&target, choices, names, words](const std::string& text) {
      for (const auto& [word, meaning] : choices)
        if (word == text) {
          target = meaning;
          return;
        }
      refuse_choice(names, text, words);
    };
    const auto word_of_target = [&target, choices] {
      for (const auto& [word, meaning] : choices)
        if (target == meaning) return word;
      return std::string();
    };
    return app.add_option_function<std::string>(names, choose, help)
        ->default_function(word_of_target)
        ->type_name(words);
  };
}

}  // namespace ringsplat::app
