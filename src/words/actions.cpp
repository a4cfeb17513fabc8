#include "words/block_session.hpp"

#include <CLI/CLI.hpp>
#include <fstream>
#include <regex>
#include <sstream>

#include "base/log.hpp"
#include "base/text.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::words {
namespace {

std::int64_t whole(const CLI::ConfigItem& item, std::int64_t least) {
  const auto number =
      item.inputs.size() == 1 ? detail::number_in<std::int64_t>(item.inputs.front()) : std::nullopt;
  if (!number || *number < least)
    throw InputError(fmt::format("{} must be a whole number from {}", item.fullname(), least));
  return *number;
}

void take(Action& action, const CLI::ConfigItem& item) {
  if (item.name == "every") {
    action.every = whole(item, 1);
  } else if (item.name == "first") {
    action.first = whole(item, 0);
  } else if (item.name == "file") {
    action.file = item.inputs.empty() ? "" : item.inputs.front();
  } else if (item.inputs.size() == 1 && item.inputs.front() != "false") {
    const std::string& value = item.inputs.front();
    action.words.push_back("--" + item.name + (value == "true" ? "" : "=" + value));
  } else if (item.inputs.size() > 1) {
    action.words.push_back(fmt::format("--{}={}", item.name, item.inputs.front()));
    action.words.insert(action.words.end(), item.inputs.begin() + 1, item.inputs.end());
  }
}

}  // namespace

std::vector<Action> parse_actions(const std::string& text) {
  std::vector<Action> actions;
  // CLI11 takes no comment behind a section's name.
  std::istringstream lines(
      std::regex_replace(text, std::regex(R"((^|\n)(\s*\[[^\]\n]*\])[ \t]*#[^\n]*)"), "$1$2"));
  std::vector<CLI::ConfigItem> items;
  try {
    items = CLI::ConfigTOML().from_config(lines);
  } catch (const CLI::Error& e) {
    throw InputError(fmt::format("this is no TOML: {}", e.what()));
  }
  for (const CLI::ConfigItem& item : items) {
    if (item.name == "--") continue;  // a section's end
    if (item.parents.size() != 1)
      throw InputError(fmt::format("'{}' belongs to no picture", item.fullname()),
                       "begin each picture by a section, as [front]");
    if (item.name == "++")
      actions.push_back({.name = item.parents.front()});
    else
      take(actions.back(), item);
  }
  for (const Action& action : actions) {
    if (action.file.empty())
      throw InputError(fmt::format("the picture {} has no file", action.name),
                       "add a line as file = \"front-{step}.png\"");
    static_cast<void>(parse_picture(action.words, {}, From::session));
  }
  return actions;
}

std::vector<Action> Actions::due(std::int64_t step) {
  std::ifstream in(path_);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) {
    warn(fmt::format("no pictures are drawn: {} cannot be read", path_.string()));
    return {};
  }
  if (text.str() != text_) {
    text_ = text.str();
    try {
      actions_ = parse_actions(text_);
      warned_.clear();
    } catch (const InputError& e) {
      warn(fmt::format("{}: {}; what it said before counts", path_.string(), e.what()));
    }
  }
  std::vector<Action> all;
  for (const Action& action : actions_) {
    if (step < action.first || (step - action.first) % action.every != 0) continue;
    std::string& file = all.emplace_back(action).file;
    constexpr std::string_view place = "{step}";
    if (const auto at = file.find(place); at != std::string::npos)
      file.replace(at, place.size(), fmt::format("{:06}", step));
    file = path_.parent_path() / file;
  }
  return all;
}

void Actions::warn(const std::string& what) {
  if (std::exchange(warned_, what) != what) log_warning("{}", what);
}

}  // namespace ringsplat::words
