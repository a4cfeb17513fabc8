#include <fmt/format.h>

#include "options/completion_model.hpp"
#include "options/option_values.hpp"

namespace ringsplat::app {
namespace {

/// For a specification of _arguments between single quotes.
std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') safe += '\\';
    safe += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  return safe;
}

std::string action_of(const CompletedValue& value) {
  const std::string paths = value.files ? "_files" : value.folders ? "_files -/" : "";
  if (value.words.empty()) return paths.empty() ? " " : paths;
  const std::string words = fmt::format("({})", joined(value.words, " "));
  if (paths.empty()) return words;
  return fmt::format("{{_alternative \"words:word:{}\" \"files:file:{}\"}}", words, paths);
}

/// An option may be repeated where the last one counts, but is offered once.
std::string specification(const CompletedOption& option) {
  std::string values;
  for (int k = 0; k < option.values; ++k)
    values +=
        fmt::format(":{}:{}", escaped(option.form.empty() ? "value" : option.form), action_of(option.value));
  const std::string rest = fmt::format("[{}]{}", escaped(option.help), values);
  if (option.names.size() == 1) return fmt::format("'{}{}'", option.names.front(), rest);
  return fmt::format("'({})'{{{}}}'{}'", joined(option.names, " "), joined(option.names, ","), rest);
}

std::string specifications(const CompletedCommand& command, const std::string& indent) {
  std::string all;
  for (const auto& option : command.options) all += indent + specification(option) + " \\\n";
  return all;
}

}  // namespace

std::string zsh_completion(const std::vector<CompletedCommand>& commands) {
  std::string described, cases;
  const CompletedCommand& program = commands.front();
  for (const auto& command : commands) {
    if (&command == &program) continue;
    described += fmt::format("    '{}:{}'\n", command.name, escaped(command.help));
    cases += fmt::format("    {})\n      _arguments \\\n{}{}        '*:argument:{}'\n      ;;\n",
                         command.name, specifications(command, "        "),
                         specifications(program, "        "), action_of(command.arguments));
  }
  return fmt::format(R"(#compdef ringsplat
# zsh completion for ringsplat, written by ringsplat --completion zsh

_ringsplat() {{
  local context state state_descr line
  typeset -A opt_args
  local -a subcommands=(
{}  )
  _arguments -C \
{}    '1:subcommand:->subcommand' \
    '*::argument:->arguments' && return
  if [[ $state == subcommand ]]; then
    _describe subcommand subcommands
    return
  fi
  case $words[1] in
{}  esac
}}

_ringsplat "$@"
)",
                     described, specifications(program, "    "), cases);
}

}  // namespace ringsplat::app
