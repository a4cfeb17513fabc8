#pragma once
#include <fmt/printf.h>

#include <cstdint>
#include <string>
#include <vector>

namespace ringsplat::detail {

/// `count` names, in which the numbers `first`, `first` + `step`, ... stand for the "%d" or "%03d" of a
/// pattern; none when it is no such pattern. Headers come from anywhere: nothing else may follow a percent
/// sign.
inline std::vector<std::string> numbered_names(const std::string& pattern, std::int64_t first,
                                               std::int64_t count, std::int64_t step) {
  const auto percent = pattern.find('%'), letter = pattern.find_first_not_of("0123456789", percent + 1);
  constexpr std::size_t most_digits = 3;
  std::vector<std::string> names;
  if (percent == std::string::npos || letter == std::string::npos || pattern[letter] != 'd' ||
      letter - percent > 1 + most_digits || pattern.find('%', letter) != std::string::npos)
    return names;
  for (std::int64_t k = 0; k < count; ++k) names.push_back(fmt::sprintf(pattern, first + k * step));
  return names;
}

}  // namespace ringsplat::detail
