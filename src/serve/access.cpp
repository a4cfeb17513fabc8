#include "serve/access.hpp"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <regex>
#include <utility>

#include "ringsplat/base/error.hpp"

namespace ringsplat::serve {
namespace {

constexpr std::string_view token_prefix = "token.";

bool same_in_constant_time(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned differs = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    differs |= static_cast<unsigned char>(a[k]) ^ static_cast<unsigned char>(b[k]);
  return differs == 0;
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

std::string make_token() {
  std::array<unsigned char, 16> bits{};
  if (getrandom(bits.data(), bits.size(), 0) != ssize_t(bits.size()))
    throw RunError("the system gives no random numbers for the page's token");
  std::string token;
  for (const unsigned char byte : bits) token += fmt::format("{:02x}", byte);
  return token;
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

Access::Access(std::string token, std::vector<std::string> hosts, std::vector<std::string> origins)
    : token_(std::move(token)), hosts_(std::move(hosts)), origins_(std::move(origins)) {}

bool Access::host_allowed(std::string_view host) const {
  return std::find(hosts_.begin(), hosts_.end(), host) != hosts_.end();
}

bool Access::origin_allowed(std::string_view origin, std::string_view host) const {
  if (origin.empty()) return false;
  if (origin == "http://" + std::string(host)) return host_allowed(host);
  return std::find(origins_.begin(), origins_.end(), origin) != origins_.end();
}

bool Access::is_token(std::string_view text) const { return same_in_constant_time(text, token_); }

bool Access::may_connect(std::string_view offered) const {
  bool speaks = false, knows = false;
  while (!offered.empty()) {
    const auto end = std::min(offered.find(','), offered.size());
    const std::string_view word = trimmed(offered.substr(0, end));
    offered.remove_prefix(std::min(end + 1, offered.size()));
    speaks = speaks || word == subprotocol;
    if (word.starts_with(token_prefix)) knows = is_token(word.substr(token_prefix.size())) || knows;
  }
  return speaks && knows;
}

}  // namespace ringsplat::serve
