#include "base/printable.hpp"

#include <cmath>
#include <string>

#include "support/catch.hpp"

using namespace ringsplat;

TEST_CASE("text stays as it is, control characters and broken UTF-8 become escapes") {
  CHECK(printable("plain text\nß € 𝄞") == "plain text\nß € 𝄞");
  CHECK(printable("a\x1b[31mred\x07\x7f\tb\r") == "a\\x1b[31mred\\x07\\x7f\\x09b\\x0d");
  CHECK(printable(std::string("a\0b", 3)) == "a\\x00b");
  CHECK(printable("\xff\xc3\xc3\xa4") == "\\xff\\xc3ä");
  CHECK(printable("\xc0\xaf \xed\xa0\x80 \xf4\x90\x80\x80") ==
        "\\xc0\\xaf \\xed\\xa0\\x80 \\xf4\\x90\\x80\\x80");
  CHECK(printable("\xc2\x9b"
                  "31m \xe2\x80\xae") == "\\xc2\\x9b31m \\xe2\\x80\\xae");
  CHECK(printable("cut short \xe2\x82") == "cut short \\xe2\\x82");
}

TEST_CASE("an excerpt has a limit in characters") {
  CHECK(excerpt("short") == "short");
  CHECK(excerpt(std::string(60, 'x')) == std::string(60, 'x'));
  CHECK(excerpt(std::string(61, 'x')) == std::string(60, 'x') + "...");
  CHECK(excerpt("äöü", 2) == "äö...");
  CHECK(excerpt("a\nb") == "a\\x0ab");
  CHECK(excerpt("").empty());
}

TEST_CASE("minus zero is zero") {
  CHECK_FALSE(std::signbit(plain(-0.0)));
  CHECK(plain(-1e-300) == -1e-300);
  CHECK(std::isnan(plain(std::nan(""))));
}
