#pragma once
#include <fmt/format.h>

#include <cstdint>
#include <string>

#include "base/text.hpp"

namespace ringsplat::detail {

/// A file name in which "%d" or "%03d" stands for a number. Headers come from anywhere, so that this is no
/// format of printf: nothing else may follow a percent sign.
class NumberedName {
 public:
  /// Not valid when the name is no such pattern.
  explicit NumberedName(const std::string& name) {
    const auto percent = name.find('%');
    const auto letter = name.find_first_not_of("0123456789", percent + 1);
    if (percent == std::string::npos || letter == std::string::npos || name[letter] != 'd' ||
        name.find('%', letter) != std::string::npos)
      return;
    const auto digits = name.substr(percent + 1, letter - percent - 1);
    constexpr int widest = 20;
    width_ = digits.empty() ? 0 : number_in<int>(digits).value_or(widest + 1);
    zeros_ = digits.starts_with('0');
    before_ = name.substr(0, percent);
    after_ = name.substr(letter + 1);
    valid_ = width_ <= widest;
  }
  bool valid() const { return valid_; }
  std::string with(std::int64_t number) const {
    const auto digits = zeros_ ? fmt::format("{:0{}}", number, width_) : fmt::format("{:{}}", number, width_);
    return before_ + digits + after_;
  }

 private:
  bool valid_ = false, zeros_ = false;
  int width_ = 0;
  std::string before_, after_;
};

}  // namespace ringsplat::detail
