#include "options/option_values.hpp"

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app;

TEST_CASE("sizes and dimensions") {
  CHECK(parse_size("640x480", "--size").x == 640);
  CHECK(parse_size("640x480", "--size").y == 480);
  CHECK(parse_size("512", "--size").y == 512);
  CHECK(parse_dims("256x128x64", "--dims") == glm::ivec3(256, 128, 64));
  CHECK(parse_dims("8,9,10", "--dims") == glm::ivec3(8, 9, 10));
  CHECK(parse_dims("7", "--dims") == glm::ivec3(7));
  CHECK(parse_memory("1.5G", "--memory") == 1.5 * 1024 * 1024 * 1024);
  CHECK(parse_memory("500M", "--memory") == 500.0 * 1024 * 1024);
  CHECK(parse_spacing("0.5x1x1e-3", "--spacing") == glm::dvec3(0.5, 1, 1e-3));
  for (const char* wrong : {"", "x", "1x", "1x2x3x4", "axb", "1.5x2", "3 x 3", "99999999999"})
    CHECK_THROWS_AS(parse_size(wrong, "--size"), InputError);
  for (const char* wrong : {"1x2", "0", "-1", "2x0x2"})
    CHECK_THROWS_AS(parse_dims(wrong, "--dims"), InputError);
  for (const char* wrong : {"", "G", "8", "8g", "0M", "-1M", "infT", "8GB"})
    CHECK_THROWS_AS(parse_memory(wrong, "--memory"), InputError);
  for (const char* wrong : {"0", "-1", "nan", "inf", "1x1"})
    CHECK_THROWS_AS(parse_spacing(wrong, "--spacing"), InputError);
}

TEST_CASE("colours are turned into linear light") {
  CHECK_FALSE(parse_colour("none", "--background").has_value());
  CHECK(*parse_colour("white", "--background") == glm::dvec3(1.0));
  CHECK(*parse_colour("#000000", "--background") == glm::dvec3(0.0));
  // IEC 61966-2-1: ((0.5 + 0.055) / 1.055)^2.4, and 10/255/12.92 on the straight part.
  const auto half = *parse_colour("0.5,0.5,0.5", "--background");
  CHECK(half.x == Approx(0.21404114).epsilon(1e-6));
  CHECK(parse_colour("#0a0000", "--background")->x == Approx(10 / 255.0 / 12.92).epsilon(1e-6));
  for (const char* wrong : {"", "#12345", "#12345g", "1,2,3", "1,1", "octarine", "-0.1,0,0"})
    CHECK_THROWS_AS(parse_colour(wrong, "--background"), InputError);
}

TEST_CASE("lists of numbers") {
  CHECK(*parse_numbers("1, -2.5;3e2\t4") == std::vector<double>{1, -2.5, 300, 4});
  CHECK(parse_numbers("  ")->empty());
  CHECK_FALSE(parse_numbers("1 two").has_value());
  CHECK_FALSE(parse_numbers("1.5deg").has_value());
}

TEST_CASE("a misspelt word finds its neighbour") {
  const std::vector<std::string> known{"--size", "--shading", "--zoom"};
  CHECK(closest("--sizee", known) == "--size");
  CHECK(closest("--shadnig", known) == "--shading");
  CHECK(closest("--nothing-like-it", known).empty());
}
