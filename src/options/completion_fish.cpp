#include <fmt/format.h>

#include "options/completion_model.hpp"
#include "options/option_values.hpp"

namespace ringsplat::app {
namespace {

std::string in_quotes(const std::string& text) {
  std::string safe = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') safe += '\\';
    safe += c;
  }
  return safe + "'";
}

/// What may follow: nothing that is a file unless the value is one.
std::string offers(const CompletedValue& value) {
  std::string words = joined(value.words, " ");
  if (value.folders) words += (words.empty() ? "" : " ") + std::string("(__fish_complete_directories)");
  return (value.files ? " -F" : " -f") + (words.empty() ? std::string() : " -a " + in_quotes(words));
}

std::string line_of(const CompletedOption& option, const std::string& condition) {
  std::string line = "complete -c ringsplat" + condition;
  for (const auto& name : option.names)
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  if (option.values > 0) line += " -r" + offers(option.value);
  return line + " -d " + in_quotes(option.help) + "\n";
}

}  // namespace

std::string fish_completion(const std::vector<CompletedCommand>& commands) {
  std::string text = "# fish completion for ringsplat, written by ringsplat --completion fish\n\n";
  const CompletedCommand& program = commands.front();
  for (const auto& option : program.options) text += line_of(option, "");
  for (const auto& command : commands) {
    if (&command == &program) continue;
    text += fmt::format("\ncomplete -c ringsplat -n __fish_use_subcommand -f -a {} -d {}\n", command.name,
                        in_quotes(command.help));
    const std::string condition = fmt::format(" -n '__fish_seen_subcommand_from {}'", command.name);
    if (!command.arguments.files)
      text += "complete -c ringsplat" + condition + offers(command.arguments) + "\n";
    for (const auto& option : command.options) text += line_of(option, condition);
  }
  return text;
}

}  // namespace ringsplat::app
