#include "options/option_list.hpp"

#include "options/split.hpp"

namespace ringsplat::app {

Option option_of(const char* heading, const char* names, const char* form, const char* fallback,
                 const char* help, Reader reader, Mark mark) {
  Option option{.names = {},
                .heading = heading,
                .form = form != nullptr ? form : reader.form,
                .fallback = {},
                .help = help,
                .reader = {},
                .mark = mark};
  if (fallback != nullptr) option.fallback = *fallback == *initial ? reader.initial : fallback;
  for (const auto name : split(names, ",")) option.names.emplace_back(name);
  option.reader = std::move(reader);
  return option;
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
  for (const Option& option : options_)
    if (option.is_given()) option.reader.read(option.given, option.name());
}

}  // namespace ringsplat::app
