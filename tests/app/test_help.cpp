// Each subcommand's help, and that its examples work.
#include <sstream>

#include "app/parsed.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;
using Catch::Matchers::Contains;

namespace {

/// The command lines below "Examples:", as words behind the program's name.
std::vector<std::vector<std::string>> examples_in(const std::string& help) {
  std::vector<std::vector<std::string>> examples;
  std::istringstream in(help.substr(std::min(help.size(), help.find("Examples:"))));
  for (std::string line; std::getline(in, line);) {
    const auto program = line.find("ringsplat ");
    if (!line.starts_with("  ") || program == std::string::npos) continue;
    std::istringstream words(line.substr(program));
    examples.emplace_back();
    words.ignore(std::string("ringsplat").size());
    for (std::string word; words >> word;) examples.back().push_back(word);
  }
  return examples;
}

}  // namespace

TEST_CASE("each subcommand's help has examples of its own, which are right") {
  for (const char* subcommand : {"render", "info", "compare", "reference", "synth"}) {
    const std::string help = said({subcommand, "--help"});
    const auto examples = examples_in(help);
    INFO(help);
    CHECK(examples.size() >= 2);
    for (const auto& words : examples) {
      INFO(words.size() << " words: " << words.at(0));
      CHECK(words.at(0) == subcommand);
      CHECK(parsed(words).error.empty());
    }
  }
}

TEST_CASE("--help of a subcommand with many options fits a screen, and says how to see the rest") {
  for (const char* subcommand : {"render", "serve", "info", "reference"}) {
    const std::string help = said({subcommand, "--help"}), all = said({subcommand, "--help-all"});
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
    for (const char* rare : {"--look-ahead", "--radius", "--link-slots"}) {
      CHECK_THAT(help, !Contains(rare));
      if (subcommand == std::string("render")) CHECK_THAT(all, Contains(rare));
    }
    CHECK(all.size() > help.size());
  }
  CHECK_THAT(said({"compare", "--help"}), Contains("--diff-scale"));
}

TEST_CASE("every option that is named as an everyday one is in --help") {
  for (const auto& subcommand : ringsplat::app::subcommands()) {
    std::istringstream names(subcommand.everyday);
    const std::string help = said({subcommand.name, "--help"});
    int found = 0, all = 0;
    for (std::string name; names >> name; ++all) found += help.find(name + " ") != std::string::npos;
    CHECK(found == all);
  }
}

TEST_CASE("the program's own examples are right") {
  const auto examples = examples_in(said({"--help"}));
  CHECK(examples.size() >= 3);
  for (const auto& words : examples) CHECK(parsed(words).error.empty());
}
