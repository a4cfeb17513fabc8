#include "serve/access.hpp"

#include <fmt/format.h>
#include <sys/random.h>

#include <array>
#include <boost/beast/http/rfc7230.hpp>
#include <regex>

#include "ringsplat/base/error.hpp"

namespace ringsplat::serve {

std::string make_token() {
  std::array<unsigned char, 16> bits{};
  if (getrandom(bits.data(), bits.size(), 0) != ssize_t(bits.size()))
    throw RunError("the system gives no random numbers for the page's token");
  return fmt::format("{:02x}", fmt::join(bits, ""));
}

std::string policy_source(std::string_view hexadecimal) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;  // in base64: two digits for three hexadecimal ones
  for (std::size_t k = 0; k < hexadecimal.size(); k += 3) {
    const std::string group = std::string(hexadecimal.substr(k, 3)) + "00";
    const unsigned long bits = std::stoul(group.substr(0, 3), nullptr, 16);
    text += {digits[bits >> 6], digits[bits & 63]};
  }
  text.back() = '=';  // 256 bits are 43 of these digits
  return "'sha256-" + text + "'";
}

std::string frame_ancestors(const std::vector<std::string>& origins) {
  static const std::regex origin("https?://([A-Za-z0-9.-]+|\\[[0-9A-Fa-f:.]+\\])(:([0-9]{1,5}|\\*))?");
  std::string list;
  for (const std::string& one : origins) {
    if (!std::regex_match(one, origin))
      throw InputError(fmt::format("--allow-frame {} is no origin of a page", one),
                       "for instance http://localhost:8888, http://localhost:* or https://hub.example.org");
    list += (list.empty() ? "" : " ") + one;
  }
  return list.empty() ? "'none'" : list;
}

bool Access::may_connect(std::string_view offered) const {
  constexpr std::string_view token_prefix = "token.";
  bool speaks = false, knows = false;
  for (const auto& item : boost::beast::http::token_list({offered.data(), offered.size()})) {
    const std::string_view word(item.data(), item.size());
    speaks = speaks || word == subprotocol;
    if (word.starts_with(token_prefix)) knows = is_token(word.substr(token_prefix.size())) || knows;
  }
  return speaks && knows;
}

}  // namespace ringsplat::serve
