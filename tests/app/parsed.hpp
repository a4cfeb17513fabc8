#pragma once
#include <sstream>

#include "app/program_runner.hpp"
#include "command_line/command_line.hpp"

namespace ringsplat::app_test {

/// The words of a text, which blanks separate.
inline std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

/// A command line behind the program's name.
inline app::CommandLine parsed(const std::vector<std::string>& words) {
  std::vector<const char*> arguments{"ringsplat"};
  for (const auto& word : words) arguments.push_back(word.c_str());
  return app::parse_command_line(int(arguments.size()), arguments.data());
}

/// What a command line asks the program to print.
inline std::string said(const std::vector<std::string>& words) {
  return std::get<app::Say>(parsed(words).command).text;
}

}  // namespace ringsplat::app_test
