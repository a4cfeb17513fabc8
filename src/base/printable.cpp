#include "base/printable.hpp"

#include <fmt/format.h>

#include <boost/locale/utf.hpp>

namespace ringsplat {
namespace {

namespace utf = boost::locale::utf;

/// Moves the first character of `text`, which is not empty, behind what is shown. A byte that begins no
/// character stands for itself.
void show_next(std::string_view& text, std::string& shown, bool lines) {
  const char* end = text.data();
  const auto code = utf::utf_traits<char>::decode(end, text.data() + text.size());
  const bool valid = code != utf::illegal && code != utf::incomplete,
             control = code < 0x20 || (code >= 0x7f && code < 0xa0),
             turns_text = (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069) ||
                          code == 0x2028 || code == 0x2029;
  const std::string_view bytes = text.substr(0, valid ? std::size_t(end - text.data()) : 1);
  if ((valid && !control && !turns_text) || (lines && code == '\n'))
    shown.append(bytes);
  else
    for (const char c : bytes) shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
  text.remove_prefix(bytes.size());
}

}  // namespace

std::string printable(std::string_view text) {
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) show_next(text, shown, true);
  return shown;
}

std::string excerpt(std::string_view text, std::size_t most) {
  std::string shown;
  for (std::size_t count = 0; count < most && !text.empty(); ++count) show_next(text, shown, false);
  return text.empty() ? shown : shown + "...";
}

}  // namespace ringsplat
