#include "formats/label_names.hpp"

#include <cstdlib>
#include <fstream>
#include <regex>
#include <utility>

#include "base/printable.hpp"

namespace ringsplat {

std::map<double, std::string> label_names(const std::filesystem::path& file) {
  constexpr std::size_t longest_line = 4096;
  static const std::regex field("(Segment[0-9]+)_(LabelValue|Name):=([^\r]+)\r?");
  std::map<std::string, std::pair<std::string, std::string>> segments;  // value and name
  std::ifstream header(file, std::ios::binary);
  std::string line;
  if (!std::getline(header, line) || line.rfind("NRRD", 0) != 0) return {};
  while (std::getline(header, line) && !line.empty() && line != "\r") {
    std::smatch found;
    if (line.size() > longest_line || !std::regex_match(line, found, field)) continue;
    auto& [value, name] = segments[found[1]];
    (found[2] == "Name" ? name : value) = found[3];
  }
  std::map<double, std::string> names;
  for (const auto& [key, segment] : segments)
    if (!segment.first.empty() && !segment.second.empty())
      names[std::strtod(segment.first.c_str(), nullptr)] = printable(segment.second);
  return names;
}

}  // namespace ringsplat
