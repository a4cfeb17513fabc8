#include "command_line/former_names.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace ringsplat::app {
namespace {

struct FormerName {
  const char *former, *today;
};
constexpr FormerName former_names[] = {{"slab", "bundle"}};

}  // namespace

std::string FormerNames::renamed(const std::string& name) {
  for (const auto& [former, today] : former_names)
    if (name == former) {
      const auto note =
          fmt::format("--{} is now called --{}; the old name goes with a later version", former, today);
      if (std::find(notes_.begin(), notes_.end(), note) == notes_.end()) notes_.push_back(note);
      return today;
    }
  return name;
}

std::vector<std::string> FormerNames::renamed(int argc, const char* const* argv) {
  std::vector<std::string> words(argv, argv + argc);
  for (std::string& word : words) {
    if (word == "--") break;
    if (!word.starts_with("--")) continue;
    const auto end = std::min(word.find('='), word.size());
    word = "--" + renamed(word.substr(2, end - 2)) + word.substr(end);
  }
  return words;
}

}  // namespace ringsplat::app
