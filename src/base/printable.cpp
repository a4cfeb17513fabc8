#include "base/printable.hpp"

#include <fmt/format.h>

#include <cstdint>

namespace ringsplat {
namespace {

struct Character {
  std::size_t bytes;
  bool shown;  ///< as it is
};

std::uint32_t byte_at(std::string_view text, std::size_t at) { return static_cast<unsigned char>(text[at]); }

/// The first character of `text`, which is not empty. A byte that begins no character stands for itself.
/// UTF-8 by RFC 3629: no overlong forms, no surrogates, nothing above 10FFFF.
Character first_character(std::string_view text) {
  const std::uint32_t lead = byte_at(text, 0);
  if (lead < 0x80) return {1, lead >= 0x20 && lead != 0x7f};
  const std::size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < bytes) return {1, false};
  std::uint32_t code = lead & (0x7fU >> bytes);
  for (std::size_t k = 1; k < bytes; ++k) {
    const std::uint32_t next = byte_at(text, k);
    if ((next & 0xc0U) != 0x80) return {1, false};
    code = code << 6U | (next & 0x3fU);
  }
  constexpr std::uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
  if (code < least[bytes] || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return {1, false};
  const bool control = code < 0xa0, turns_text = (code >= 0x202a && code <= 0x202e) ||
                                                 (code >= 0x2066 && code <= 0x2069) || code == 0x2028 ||
                                                 code == 0x2029;
  return {bytes, !control && !turns_text};
}

void append(std::string& shown, std::string_view bytes, bool as_it_is) {
  if (as_it_is)
    shown.append(bytes);
  else
    for (const char c : bytes) shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
}

}  // namespace

std::string printable(std::string_view text) {
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const Character c = first_character(text);
    append(shown, text.substr(0, c.bytes), c.shown || text.front() == '\n');
    text.remove_prefix(c.bytes);
  }
  return shown;
}

std::string excerpt(std::string_view text, std::size_t most) {
  std::string shown;
  for (std::size_t count = 0; count < most && !text.empty(); ++count) {
    const Character c = first_character(text);
    append(shown, text.substr(0, c.bytes), c.shown);
    text.remove_prefix(c.bytes);
  }
  return text.empty() ? shown : shown + "...";
}

}  // namespace ringsplat
