#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

/// What shells need to know of the command line to complete it.
namespace ringsplat::app {

/// A value that is one of some words, a file, a folder or free.
struct CompletedValue {
  std::vector<std::string> words = {};
  bool files = false, folders = false;
};

struct CompletedOption {
  std::vector<std::string> names;  ///< with dashes; none for an argument without
  std::string form;                ///< what --help shows for the value
  std::string help;                ///< what it does, without details
  int values = 0;                  ///< that follow it; 0 for a flag
  CompletedValue value;
};

struct CompletedCommand {
  std::string name, help;
  std::vector<CompletedOption> options;
  CompletedValue arguments;
};

/// The program's own options come first, below an empty name; subcommands follow.
std::vector<CompletedCommand> completed_commands(const CLI::App& program);

/// Scripts by shell.
std::string bash_completion(const std::vector<CompletedCommand>& commands);
std::string zsh_completion(const std::vector<CompletedCommand>& commands);
std::string fish_completion(const std::vector<CompletedCommand>& commands);

}  // namespace ringsplat::app
