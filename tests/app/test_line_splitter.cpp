#include "app/views.hpp"

#include <vector>

#include "support/catch.hpp"

using ringsplat::app::LineSplitter;

namespace {

std::vector<LineSplitter::Line> lines_of(const std::vector<std::string>& pieces) {
  std::vector<LineSplitter::Line> lines;
  const auto take = [&](const LineSplitter::Line& line) { lines.push_back(line); };
  LineSplitter splitter;
  for (const auto& piece : pieces) splitter.add(piece, take);
  splitter.end(take);
  return lines;
}

}  // namespace

TEST_CASE("lines do not depend on the pieces they come in") {
  for (const auto& pieces : std::vector<std::vector<std::string>>{{"one\n\nthree\nfour"},
                                                                  {"o", "ne\n", "\nth", "ree", "\nfour"}}) {
    const auto lines = lines_of(pieces);
    REQUIRE(lines.size() == 4);
    CHECK(lines[0].text == "one");
    CHECK(lines[1].text.empty());
    CHECK(lines[2].text == "three");
    CHECK(lines[3].text == "four");
    for (std::size_t k = 0; k < 4; ++k) {
      CHECK(lines[k].number == k + 1);
      CHECK_FALSE(lines[k].too_long);
    }
  }
  CHECK(lines_of({"a\n", "b\n"}).size() == 2);
  CHECK(lines_of({}).empty());
}

TEST_CASE("of a line that is too long only the beginning is kept, and the next line is whole") {
  const std::string most(LineSplitter::most_bytes, 'x');
  const auto lines = lines_of({most + "\n", most, "y", most + most, "\nshort\n", most + "yy\n"});
  REQUIRE(lines.size() == 4);
  CHECK(lines[0].text == most);
  CHECK_FALSE(lines[0].too_long);
  CHECK(lines[1].text == most);
  CHECK(lines[1].too_long);
  CHECK(lines[1].number == 2);
  CHECK(lines[2].text == "short");
  CHECK(lines[2].number == 3);
  CHECK(lines[3].too_long);
  CHECK(lines[3].number == 4);
}

TEST_CASE("a line that never ends is told of as soon as it is too long") {
  std::size_t told = 0;
  const auto take = [&](const LineSplitter::Line& line) { told += line.too_long ? 1 : 100; };
  LineSplitter splitter;
  for (int k = 0; k < 100; ++k) splitter.add(std::string(1000, 'x'), take);
  CHECK(told == 1);
}
