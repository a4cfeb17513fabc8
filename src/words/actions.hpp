#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace ringsplat::words {

/// A picture that is wanted now and then.
struct Action {
  std::string name;  ///< the section's
  std::int64_t every = 1, first = 0;
  std::string file;                ///< {step}: the step's number in six digits
  std::vector<std::string> words;  ///< for parse_picture()
};

/// Of a TOML file: a section is a picture, its keys `every`, `first` and `file`, the others options of
/// `ringsplat render`. Throws InputError.
std::vector<Action> parse_actions(const std::string& text);

/// Pictures that a file asks for, which may be changed while a program runs: as Ascent's actions (Larsen et
/// al. 2022).
class Actions {
 public:
  explicit Actions(std::filesystem::path path) : path_(std::move(path)) {}

  /// Those that the file has now and that are due after a step, with the files that they are written to:
  /// beside it where they are relative. What is wrong in it is warned of, and what it said before counts.
  std::vector<Action> due(std::int64_t step);
  /// Warns, unless of the same as the last time.
  void warn(const std::string& what);

 private:
  std::filesystem::path path_;
  std::string text_, warned_;  ///< as they were last
  std::vector<Action> actions_;
};

}  // namespace ringsplat::words
