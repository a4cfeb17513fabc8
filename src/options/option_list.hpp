#pragma once
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "options/option_row.hpp"

namespace ringsplat::app {

/// An option, and the words that were given for it.
struct Option {
  Words names;  ///< with their dashes, of which an argument's name has none
  std::string heading, form;
  std::string fallback;  ///< empty: there is none to show
  std::string help;
  Reader reader;
  Mark mark = Mark::none;
  Words given = {};

  /// The long one.
  const std::string& name() const { return names.back(); }
  bool has_name(std::string_view name) const {
    return std::find(names.begin(), names.end(), name) != names.end();
  }
  bool is_positional() const { return !name().starts_with('-'); }
  bool is_flag() const { return reader.words == 0; }
  bool is_given() const { return !given.empty(); }
};

/// The row's option, to be shown and to be read.
Option option_of(const char* heading, const char* names, const char* form, const char* fallback,
                 const char* help, Reader reader, Mark mark);

/// A subcommand's options, in the order of --help.
class OptionList {
 public:
  void add(Option option) { options_.push_back(std::move(option)); }
  void leave_out(Mark mark) {
    std::erase_if(options_, [mark](const Option& option) { return option.mark == mark; });
  }

  auto begin() { return options_.begin(); }
  auto end() { return options_.end(); }
  auto begin() const { return options_.begin(); }
  auto end() const { return options_.end(); }
  /// The option of this name, or null.
  const Option* find(std::string_view name) const;
  /// False when there is no such option, too.
  bool is_given(std::string_view name) const;
  /// Passes what was given to its targets, in the list's order. Throws InputError.
  void read() const;

 private:
  std::vector<Option> options_;
};

/// Adds a group's options, which fill `options`; these must outlive the reading.
template <class Options>
void add_options(OptionList& list, const OptionGroup<Options>& group, Options& options) {
  for (const auto& row : group.rows)
    list.add(option_of(group.heading, row.names, row.form, row.fallback, row.help, row.reader_of(options),
                       row.mark));
}

}  // namespace ringsplat::app
