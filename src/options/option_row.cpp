#include "options/option_row.hpp"

#include <fmt/format.h>

#include "ringsplat/base/error.hpp"

namespace ringsplat::app {

void add_option(CLI::App& app, const char* heading, const char* names, const char* form, const char* fallback,
                const char* help, const Binding& binding, bool required) {
  CLI::Option* option = binding(app, names, help)->required(required);
  if (!option->get_positional()) option->group(heading);  // CLI11 gives arguments a heading of its own
  if (form != nullptr) option->type_name(form);
  if (fallback == nullptr) return;
  if (*fallback == *initial)
    option->capture_default_str();
  else
    option->default_str(fallback);
}

Binding flag(bool& target) {
  return [&target](CLI::App& app, const std::string& names, const std::string& help) {
    return app.add_flag(names, target, help);
  };
}

Binding clearing_flag(bool& target) {
  return [&target](CLI::App& app, const std::string& names, const std::string& help) {
    return app.add_flag_callback(
        names, [&target] { target = false; }, help);
  };
}

void refuse_choice(const std::string& option, const std::string& text, const std::string& words) {
  throw InputError(fmt::format("{} cannot be '{}'", option, text), fmt::format("use {} {}", option, words));
}

}  // namespace ringsplat::app
