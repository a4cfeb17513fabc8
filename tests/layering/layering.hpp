#pragma once
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace layering {

/// Which rooms a room may include besides itself.
using Rules = std::map<std::string, std::set<std::string>>;

/// The exact form of the table in docs/design.md, "Rooms".
const Rules& house_rules();

/// One line each, "FILE:LINE: what is wrong", sorted; empty when `root` (with include/ringsplat, src and
/// src/CMakeLists.txt) keeps the rules. Throws std::runtime_error when there is no source file to check.
std::vector<std::string> violations(const std::filesystem::path& root, const Rules& rules);

}  // namespace layering
