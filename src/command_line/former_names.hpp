#pragma once
#include <string>
#include <vector>

namespace ringsplat::app {

/// Options' former names, which still work and are in no help.
class FormerNames {
 public:
  /// The words of a command line with the names of today.
  std::vector<std::string> renamed(int argc, const char* const* argv);
  /// The same for an option's name without dashes, as --config files have it.
  std::string renamed(const std::string& name);
  /// What to tell the user: a line for each former name that was met.
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  std::vector<std::string> notes_;
};

}  // namespace ringsplat::app
