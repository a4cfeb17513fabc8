#include "options/completion_model.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>

#include "classify/colour_maps.hpp"
#include "options/option_values.hpp"
#include "ringsplat/classify/transfer_function.hpp"
#include "ringsplat/volume/grid.hpp"
#include "volume/synth.hpp"

namespace ringsplat::app {
namespace {

template <class Range>
std::vector<std::string> names_in(const Range& range) {
  std::vector<std::string> names;
  for (const auto& entry : range) names.emplace_back(entry.name);
  return names;
}

std::vector<std::string> scalar_types() {
  std::vector<std::string> names;
  for (int type = 0; type <= int(ScalarType::float64); ++type) names.push_back(to_string(ScalarType(type)));
  return names;
}

/// Words that an option's form does not list.
std::vector<std::string> names_for(const CLI::Option& option) {
  if (option.check_name("--tf")) return names_in(preset_names());
  if (option.check_name("--colours")) {
    auto names = names_in(colour_map_names());
    for (auto& name : names) std::replace(name.begin(), name.end(), ' ', '-');  // also known so
    names.emplace_back("list");
    return names;
  }
  if (option.check_name("--background")) return colour_names();
  if (option.check_name("--type")) return scalar_types();
  if (option.check_name("--view")) return {"front", "back", "left", "right", "top", "bottom"};
  if (option.get_positional() && option.get_type_name() == "NAME") return names_in(synth_names());
  return {};
}

std::vector<std::string> alternatives(const std::string& form) {
  std::vector<std::string> parts;
  for (std::size_t at = 0; at <= form.size();) {
    const auto bar = std::min(form.find('|', at), form.size());
    parts.push_back(form.substr(at, bar - at));
    at = bar + 1;
  }
  return parts;
}

/// Words stand for themselves; what is a kind of value has a capital letter.
bool is_word(const std::string& part) {
  return !part.empty() && std::all_of(part.begin(), part.end(), [](unsigned char c) {
    return std::islower(c) != 0 || std::isdigit(c) != 0 || c == '.' || c == '-';
  });
}

bool begins_with_any(const std::string& part, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* word) { return part.starts_with(word); });
}

CompletedValue value_of(const CLI::Option& option) {
  CompletedValue value{.words = names_for(option)};
  for (const std::string& part : alternatives(option.get_type_name())) {
    if (is_word(part)) value.words.push_back(part);
    if (begins_with_any(part, {"FILE", "VOLUME", "LIST"})) value.files = true;
    if (part == "FOLDER") value.folders = true;
  }
  if (option.get_positional() && value.words.empty()) value.files = true;
  return value;
}

/// What an option does, on a line beside its name.
std::string short_help(const std::string& help) {
  constexpr std::size_t longest = 76;
  const std::string first = help.substr(0, help.find(';'));
  if (first.size() <= longest) return first;
  return first.substr(0, first.rfind(' ', longest)) + " ...";
}

CompletedOption completed(const CLI::Option& option) {
  CompletedOption all{.names = {},
                      .form = option.get_type_name(),
                      .help = short_help(option.get_description()),
                      .values = 0,
                      .value = value_of(option)};
  for (const auto& name : option.get_snames()) all.names.push_back("-" + name);
  for (const auto& name : option.get_lnames()) all.names.push_back("--" + name);
  constexpr int most = 12;  // of --matrix; what may be given several times says more
  if (option.get_items_expected_max() > 0)
    all.values = option.get_items_expected_max() <= most ? option.get_items_expected_max() : 1;
  return all;
}

CompletedCommand completed(const CLI::App& app, const std::string& name) {
  CompletedCommand command{.name = name, .help = app.get_description(), .options = {}, .arguments = {}};
  for (const CLI::Option* option : app.get_options())
    if (option->get_positional())
      command.arguments = value_of(*option);
    else
      command.options.push_back(completed(*option));
  return command;
}

}  // namespace

std::vector<CompletedCommand> completed_commands(const CLI::App& program) {
  std::vector<CompletedCommand> commands{completed(program, "")};
  for (const CLI::App* app : program.get_subcommands({}))
    commands.push_back(completed(*app, app->get_name()));
  return commands;
}

}  // namespace ringsplat::app
