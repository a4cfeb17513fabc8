#include "formats/raw/raw_name.hpp"

#include <fmt/format.h>

#include <charconv>
#include <regex>

#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

int dimension(const std::string& digits, const std::filesystem::path& path) {
  int value = 0;
  if (std::from_chars(digits.data(), digits.data() + digits.size(), value).ec != std::errc{})
    throw InputError(fmt::format("{}: the dimension {} in its name is too large", path.string(), digits),
                     "give the true size with --dims");
  return value;
}

}  // namespace

std::optional<RawName> parse_raw_name(const std::filesystem::path& path) {
  static const std::regex pattern(R"(.*_(\d+)x(\d+)x(\d+)_([A-Za-z0-9]+)\.raw)", std::regex::icase);
  const std::string name = path.filename().string();
  std::smatch match;
  if (!std::regex_match(name, match, pattern)) return {};
  const auto size = [&](std::size_t i) { return dimension(match[i].str(), path); };
  return RawName{{size(1), size(2), size(3)}, scalar_type_from(match[4].str())};
}

}  // namespace ringsplat::detail
