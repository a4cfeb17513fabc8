#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "options/option_list.hpp"

/// Rules between options: a table that command lines are checked against and that the manual page lists.
namespace ringsplat::app {

/// Options of a subcommand, or values of them.
struct Which {
  std::string option;                     ///< empty: every option …
  std::string heading = {};               ///< … or every option below this heading of --help
  std::optional<std::string> value = {};  ///< nothing: any value
  std::optional<Mark> mark = {};          ///< … or every one whose row is so marked
};

/// Each of them, or one of them.
struct Some : std::vector<Which> {
  using std::vector<Which>::vector;
  /// Words with blanks between: "--path", "--path=-", "=" for every option with an empty value, and "@View"
  /// for every option below this heading.
  Some(const char* words);
};

enum class Relation {
  excludes,  ///< none of `others` may be given with it
  needs,     ///< one of `others` must be given with it, where the subcommand has one of them
  refused    ///< it may not be given
};

struct Rule {
  Some options;  ///< each of them …
  Relation relation;
  Some others;
  const char* way_out;            ///< with {0} for the option
  const char* problem = nullptr;  ///< with {0} for the option and {1} for the others; null: the usual words
};

/// In the order of application: the first broken rule is reported.
std::span<const Rule> rules();

/// True when `which` means the option, with any value.
inline bool means(const Which& which, const Option& option) {
  return (which.option.empty() || option.has_name(which.option)) &&
         (which.heading.empty() || option.heading == which.heading) &&
         (!which.mark || option.mark == *which.mark);
}

/// True when the list has an option that `which` means.
inline bool has(const OptionList& list, const Which& which) {
  return std::any_of(list.begin(), list.end(), [&](const Option& option) { return means(which, option); });
}

/// Throws InputError, with the way out as hint, when what is given breaks a rule.
void refuse_contradictions(const OptionList& list);

}  // namespace ringsplat::app
