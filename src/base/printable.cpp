#include "base/printable.hpp"

#include <fmt/format.h>

#include <boost/locale/utf.hpp>

namespace ringsplat {
namespace {

namespace utf = boost::locale::utf;

struct Character {
  std::size_t bytes;
  bool shown;  ///< as it is
};

/// The first character of `text`, which is not empty. A byte that begins no character stands for itself.
Character first_character(std::string_view text) {
  const char* end = text.data();
  const auto code = utf::utf_traits<char>::decode(end, text.data() + text.size());
  if (code == utf::illegal || code == utf::incomplete) return {1, false};
  const bool control = code < 0x20 || (code >= 0x7f && code < 0xa0),
             turns_text = (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069) ||
                          code == 0x2028 || code == 0x2029;
  return {std::size_t(end - text.data()), !control && !turns_text};
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
