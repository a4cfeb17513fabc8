// Each subcommand's help, and that its examples work.
#include <sstream>

#include "app/program_runner.hpp"
#include "command_line/command_line.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;
using Catch::Matchers::Contains;
using ringsplat::app::CommandLine;
using ringsplat::app::parse_command_line;

namespace {

/// The command lines below "Examples:", as words, without a launcher's part.
std::vector<std::vector<std::string>> examples_in(const std::string& help) {
  std::vector<std::vector<std::string>> examples;
  std::istringstream in(help.substr(std::min(help.size(), help.find("Examples:"))));
  for (std::string line; std::getline(in, line);) {
    const auto program = line.find("ringsplat ");
    if (!line.starts_with("  ") || program == std::string::npos) continue;
    std::istringstream words(line.substr(program));
    examples.emplace_back();
    for (std::string word; words >> word;) examples.back().push_back(word);
  }
  return examples;
}

CommandLine parse(const std::vector<std::string>& words) {
  std::vector<const char*> arguments;
  for (const auto& word : words) arguments.push_back(word.c_str());
  return parse_command_line(int(arguments.size()), arguments.data());
}

}  // namespace

TEST_CASE("each subcommand's help has examples of its own, which are right") {
  for (const char* subcommand : {"render", "info", "compare", "reference", "synth"}) {
    const CommandLine line = parse({"ringsplat", subcommand, "--help"});
    const auto* said = std::get_if<ringsplat::app::Say>(&line.command);
    REQUIRE(said != nullptr);
    const auto examples = examples_in(said->text);
    INFO(said->text);
    CHECK(examples.size() >= 2);
    for (const auto& words : examples) {
      INFO(words.size() << " words: " << words.at(1));
      CHECK(words.at(1) == subcommand);
      CHECK(parse(words).error.empty());
    }
  }
}

TEST_CASE("--help of a subcommand with many options fits a screen, and says how to see the rest") {
  const auto text_of = [](const char* subcommand, const char* flag) {
    return std::get<ringsplat::app::Say>(parse({"ringsplat", subcommand, flag}).command).text;
  };
  for (const char* subcommand : {"render", "serve", "info", "reference"}) {
    const std::string help = text_of(subcommand, "--help"), all = text_of(subcommand, "--help-all");
    INFO(help);
    std::istringstream in(help);
    int lines = 0;
    for (std::string line; std::getline(in, line); ++lines) CHECK(line.size() <= 108);
    CHECK(lines <= 51);
    CHECK_THAT(help, Contains("(more with --help-all):\n") && Contains("--help-all shows all options"));
    for (const char* everyday : {"--channel", "--clip", "--size", "--tf"})
      if (subcommand != std::string("info")) CHECK_THAT(help, Contains(everyday));
    if (subcommand == std::string("render") || subcommand == std::string("serve"))
      CHECK_THAT(help, Contains("--threads-per-rank"));
    for (const char* rare : {"--look-ahead", "--normalisation", "--link-slots"}) {
      CHECK_THAT(help, !Contains(rare));
      if (subcommand == std::string("render")) CHECK_THAT(all, Contains(rare));
    }
    CHECK(all.size() > help.size());
  }
  CHECK_THAT(text_of("compare", "--help"), Contains("--diff-scale"));
}

TEST_CASE("every option that is named as an everyday one is in --help") {
  for (const auto& subcommand : ringsplat::app::subcommands()) {
    std::istringstream names(subcommand.everyday);
    const std::string help =
        std::get<ringsplat::app::Say>(parse({"ringsplat", subcommand.name, "--help"}).command).text;
    int found = 0, all = 0;
    for (std::string name; names >> name; ++all) found += help.find(name + " ") != std::string::npos;
    CHECK(found == all);
  }
}

TEST_CASE("the program's own examples are right") {
  const CommandLine line = parse({"ringsplat", "--help"});
  const auto examples = examples_in(std::get<ringsplat::app::Say>(line.command).text);
  CHECK(examples.size() >= 3);
  for (const auto& words : examples) CHECK(parse(words).error.empty());
}
