#include "app/views.hpp"

#include <sstream>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app;

namespace {

std::vector<Camera> parse_path(const std::string& text, const std::string& where, const Camera& defaults) {
  std::istringstream in(text);
  return app::parse_path(in, where, defaults);
}

}  // namespace

TEST_CASE("an orbit goes once around") {
  const Camera start{.azimuth = 10, .elevation = 20, .roll = 30, .zoom = 2};
  const auto cameras = orbit(start, 8);
  REQUIRE(cameras.size() == 8);
  for (std::size_t k = 0; k < 8; ++k)
    CHECK(cameras[k] == Camera{.azimuth = 10 + 45.0 * double(k), .elevation = 20, .roll = 30, .zoom = 2});
}

TEST_CASE("a path has a view a line") {
  const Camera defaults{.roll = 5, .zoom = 3};
  const auto path = parse_path("# where to go\n10 20\n\n-30,40;6, 1.5\r\n{\"zoom\": 2, \"azimuth\": 1e1}\n",
                               "p.csv", defaults);
  REQUIRE(path.size() == 3);
  CHECK(path[0] == Camera{.azimuth = 10, .elevation = 20, .roll = 5, .zoom = 3});
  CHECK(path[1] == Camera{.azimuth = -30, .elevation = 40, .roll = 6, .zoom = 1.5});
  CHECK(path[2] == Camera{.azimuth = 10, .roll = 5, .zoom = 2});
}

TEST_CASE("a heading names a path's columns") {
  const auto path = parse_path("Zoom,Azimuth\n2,90\n", "p.csv", {});
  REQUIRE(path.size() == 1);
  CHECK(path[0] == Camera{.azimuth = 90, .zoom = 2});
}

TEST_CASE("a path may give matrices") {
  const auto path = parse_path(R"({"matrix": [1,0,0,5, 0,1,0,6, 0,0,1,7]})", "p.json", {});
  REQUIRE(path.at(0).matrix.has_value());
  CHECK((*path[0].matrix)[3] == 5);
  CHECK((*path[0].matrix)[11] == 7);
}

TEST_CASE("a wrong path names its line") {
  const auto refused = [](const std::string& text, const std::string& part) {
    CHECK_THROWS_WITH(parse_path(text, "p.csv", {}), Catch::Matchers::Contains(part));
  };
  refused("0 0\n0 0 0 1 9\n", "p.csv:2");
  refused("0 0\n\nleft right\n", "p.csv:3");
  refused("{\"azimut\": 3}\n", "azimut");
  refused("{\"azimuth\": \"3\"}\n", "p.csv:1");
  refused("{\"matrix\": [1, 2]}\n", "matrix");
  refused("{\"azimuth\": 3\n", "p.csv:1");
  refused("0 0\n" + std::string(5000, '1') + "\n",
          "p.csv:2: '" + std::string(60, '1') + "...' has more than 4096");
  refused("left \x1b[2J" + std::string(100, 'x'),
          "'left \\x1b[2J" + std::string(51, 'x') + "...' is not 1 to 4");
  refused("{\"a\\u0007\": 1}\n", "'a\\x07' is not azimuth");
  refused("", "no view");
  refused("azimuth elevation\n", "no view");
  RenderOptions options;
  options.path = "/no/such/file.csv";
  CHECK_THROWS_AS(views_of(options), InputError);
}

TEST_CASE("frames are numbered before the ending") {
  CHECK(numbered("out/turn.png", 7) == "out/turn-0007.png");
  CHECK(numbered("a.b.exr", 12345) == "a.b-12345.exr");
}
