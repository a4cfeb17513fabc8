#include <fmt/format.h>

#include "options/completion_model.hpp"
#include "options/option_values.hpp"

namespace ringsplat::app {
namespace {

/// Statements that offer a value; words have no letter that the shell would read.
std::string offers(const CompletedValue& value) {
  std::vector<std::string> statements;
  if (!value.words.empty()) statements.push_back(fmt::format("words='{}'", joined(value.words, " ")));
  if (value.files || value.folders) statements.emplace_back(value.files ? "paths=file" : "paths=directory");
  if (statements.empty()) statements.emplace_back(":");
  return joined(statements, "; ");
}

std::string names_of(const CompletedCommand& command) {
  std::vector<std::string> names;
  for (const auto& option : command.options)
    names.insert(names.end(), option.names.begin(), option.names.end());
  return joined(names, " ");
}

/// What follows an option, by subcommand and option.
std::string cases_of_values(const CompletedCommand& command) {
  std::string cases;
  for (const auto& option : command.options) {
    if (option.values == 0) continue;
    std::vector<std::string> patterns;
    for (const auto& name : option.names)
      patterns.push_back((command.name.empty() ? "*" : command.name) + ":" + name);
    cases += fmt::format("    {}) {} ;;\n", joined(patterns, " | "), offers(option.value));
  }
  return cases;
}

constexpr const char* script = R"(# bash completion for ringsplat, written by ringsplat --completion bash

_ringsplat() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}}
  local subcommand= words= paths= word
  # In --option=value the = is a word of its own.
  if [[ $current == = ]]; then
    current=
  elif [[ $previous == = ]]; then
    previous=${{COMP_WORDS[COMP_CWORD - 2]}}
  fi
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case $word in
      {subcommands}) subcommand=$word && break ;;
    esac
  done
  COMPREPLY=()
  case $subcommand:$previous in
{values}    *)
      case $current:$subcommand in
        -*:) words='{program_options}' ;;
{options}        *:) words='{words}' ;;
{arguments}      esac
      ;;
  esac
  [[ -z $words ]] || mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  [[ -z $paths ]] || compopt -o filenames 2>/dev/null
  [[ -z $paths ]] || mapfile -t -O "${{#COMPREPLY[@]}}" COMPREPLY < <(compgen -A "$paths" -- "$current")
  return 0
}}

complete -F _ringsplat ringsplat
)";

}  // namespace

std::string bash_completion(const std::vector<CompletedCommand>& commands) {
  const CompletedCommand& program = commands.front();
  std::vector<std::string> names;
  std::string values, options, arguments;
  for (const auto& command : commands) {
    if (&command == &program) continue;
    names.push_back(command.name);
    values += cases_of_values(command);
    options +=
        fmt::format("        -*:{}) words='{} {}' ;;\n", command.name, names_of(command), names_of(program));
    arguments += fmt::format("        *:{}) {} ;;\n", command.name, offers(command.arguments));
  }
  values += cases_of_values(program);
  return fmt::format(fmt::runtime(script), fmt::arg("subcommands", joined(names, " | ")),
                     fmt::arg("values", values), fmt::arg("program_options", names_of(program)),
                     fmt::arg("options", options), fmt::arg("words", joined(names, " ")),
                     fmt::arg("arguments", arguments));
}

}  // namespace ringsplat::app
