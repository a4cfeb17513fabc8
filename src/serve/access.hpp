#pragma once
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace ringsplat::serve {

/// 128 random bits of the system's generator, as 32 hexadecimal digits. Throws RunError when it gives none.
std::string make_token();

/// Who may see the page and connect. A page of another site that the user also has open can send requests
/// here, but it can set neither Host nor Origin, and does not know the token.
struct Access {
  std::string token;
  std::vector<std::string> hosts;    ///< exactly what a request's Host may be, as "localhost:8080"
  std::vector<std::string> origins;  ///< pages besides the hosts' that may connect: "https://hub.example.org"

  bool host_allowed(std::string_view host) const {
    return std::find(hosts.begin(), hosts.end(), host) != hosts.end();
  }
  /// `host`: of the same request.
  bool origin_allowed(std::string_view origin, std::string_view host) const {
    if (origin.empty()) return false;
    if (origin == "http://" + std::string(host)) return host_allowed(host);
    return std::find(origins.begin(), origins.end(), origin) != origins.end();
  }
  /// Takes as long for every text of the right length.
  bool is_token(std::string_view text) const {
    unsigned differs = text.size() != token.size() ? 1 : 0;
    for (std::size_t k = 0; k < std::min(text.size(), token.size()); ++k)
      differs |= static_cast<unsigned char>(text[k] ^ token[k]);
    return differs == 0;
  }
  /// `offered`: a WebSocket request's list of subprotocols, which must have "ringsplat.v1" and
  /// "token.TOKEN".
  bool may_connect(std::string_view offered) const;
};

/// The list of frame-ancestors in a Content-Security-Policy: origins such as "https://hub.example.org" or
/// "http://localhost:*", or 'none'. Throws InputError that names --allow-frame for anything else, as a blank
/// or a semicolon would change the rest of the policy.
std::string frame_ancestors(const std::vector<std::string>& origins);

/// A SHA-256 as a Content-Security-Policy names what may stand in a page: "'sha256-...'".
std::string policy_source(std::string_view hexadecimal);

/// The page, which has its style sheet and all modules of src/serve/page in it.
struct PageFile {
  std::string_view html, gzipped;
  std::string_view script_hash, style_hash, hash;  ///< SHA-256 in hexadecimal digits
};
extern const PageFile page_file;

/// The subprotocol that the server chooses.
inline constexpr std::string_view subprotocol = "ringsplat.v1";

}  // namespace ringsplat::serve
