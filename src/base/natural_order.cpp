#include "base/natural_order.hpp"

#include <algorithm>
#include <string_view>

namespace ringsplat {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

bool naturally_before(const std::string& a, const std::string& b) {
  std::size_t i = 0, k = 0;
  while (i < a.size() && k < b.size()) {
    if (!is_digit(a[i]) || !is_digit(b[k])) {
      if (a[i] != b[k]) return a[i] < b[k];
      ++i, ++k;
      continue;
    }
    const auto number_at = [](const std::string& text, std::size_t& at) {
      const std::size_t begin = std::min(text.find_first_not_of('0', at), text.size());
      for (at = begin; at < text.size() && is_digit(text[at]);) ++at;
      return std::string_view(text).substr(begin, at - begin);
    };
    const std::string_view one = number_at(a, i), other = number_at(b, k);
    if (one.size() != other.size()) return one.size() < other.size();
    if (one != other) return one < other;
  }
  return a.size() - i != b.size() - k ? a.size() - i < b.size() - k : a < b;
}

}  // namespace ringsplat
