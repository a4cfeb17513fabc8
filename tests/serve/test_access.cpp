#include "serve/access.hpp"

#include <string>
#include <vector>

#include "support/catch.hpp"

using namespace ringsplat::serve;

namespace {

const std::string token = "0123456789abcdef0123456789abcdef";
const Access rules{token, {"127.0.0.1:80", "[::1]:80"}, {"https://hub.example.org"}};

}  // namespace

TEST_CASE("A token has 128 bits and is another one each time") {
  const std::string first = make_token();
  CHECK(first.size() == 32);
  CHECK(first.find_first_not_of("0123456789abcdef") == std::string::npos);
  CHECK(first != make_token());
}

TEST_CASE("Only the very names of the server are its hosts") {
  CHECK(rules.host_allowed("127.0.0.1:80"));
  CHECK(rules.host_allowed("[::1]:80"));
  for (const char* other :
       {"", "127.0.0.1", "127.0.0.1:8", "127.0.0.1:800", "127.0.0.1:80.evil.org", "evil.org:80"})
    CHECK(!rules.host_allowed(other));
}

TEST_CASE("Only pages of the same host and those that were allowed may connect") {
  CHECK(rules.origin_allowed("http://127.0.0.1:80", "127.0.0.1:80"));
  CHECK(rules.origin_allowed("https://hub.example.org", "127.0.0.1:80"));
  for (const char* other : {"", "null", "https://127.0.0.1:80", "http://[::1]:80", "http://127.0.0.1:80/",
                            "https://hub.example.org.evil.org", "http://hub.example.org"})
    CHECK(!rules.origin_allowed(other, "127.0.0.1:80"));
  CHECK(!rules.origin_allowed("http://evil.org:80", "evil.org:80"));
}

TEST_CASE("Only the token itself is the token") {
  CHECK(rules.is_token(token));
  for (const std::string& other :
       std::vector<std::string>{"", token.substr(1), token + "0", std::string(32, '0')})
    CHECK(!rules.is_token(other));
}

TEST_CASE("A client must offer both the subprotocol and the token") {
  CHECK(rules.may_connect("ringsplat.v1, token." + token));
  CHECK(rules.may_connect("token." + token + " ,\tringsplat.v1,other"));
  for (const std::string& other :
       std::vector<std::string>{"", "ringsplat.v1", "token." + token, "ringsplat.v1, " + token,
                                "ringsplat.v1, token." + token.substr(1),
                                "ringsplat.v1, token." + token + "0", "ringsplat.v1 token." + token,
                                "ringsplat.v1, token.", ",,,", "ringsplat.v1, token." + std::string(32, '0')})
    CHECK(!rules.may_connect(other));
}

TEST_CASE("A page is framed by nobody but the origins that were allowed") {
  CHECK(frame_ancestors({}) == "'none'");
  CHECK(frame_ancestors({"http://localhost:*", "https://hub.example.org", "http://[::1]:8888"}) ==
        "http://localhost:* https://hub.example.org http://[::1]:8888");
  for (const char* other : {"", "*", "localhost", "http://*", "https://hub.example.org/", "http://a b",
                            "http://a;script-src *", "http://a, http://b", "ftp://a", "'self'"})
    CHECK_THROWS_WITH(frame_ancestors({other}), Catch::Matchers::Contains("--allow-frame"));
}
