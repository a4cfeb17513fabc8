#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <random>
#include <set>

#include "classify/normal_lattice.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

double degrees_between(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / std::numbers::pi;
}

}  // namespace

TEST_CASE("each code decodes to a unit vector that encodes to it again") {
  std::set<std::tuple<double, double, double>> seen;
  for (int code = 1; code <= lattice_codes; ++code) {
    const glm::dvec3 n = decode_normal(NormalCode(code));
    REQUIRE(glm::length(n) == Approx(1.0).epsilon(1e-15));
    REQUIRE(encode_normal(n) == code);
    seen.insert({n.x, n.y, n.z});
  }
  REQUIRE(seen.size() == std::size_t(lattice_codes));
  REQUIRE(lattice_codes == 65018);
  REQUIRE(decode_normal(no_normal) == glm::dvec3(0));
  for (int code = lattice_codes + 1; code < int(normal_codes); ++code)
    REQUIRE(decode_normal(NormalCode(code)) == glm::dvec3(0));
}

TEST_CASE("the axes and the poles are exact, opposite directions are opposite") {
  for (int k = 0; k < 3; ++k)
    for (const double sign : {1.0, -1.0}) {
      glm::dvec3 axis(0);
      axis[k] = sign;
      REQUIRE(decode_normal(encode_normal(axis)) == axis);
    }
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 10000; ++trial) {
    const glm::dvec3 n{normal(random), normal(random), normal(random)};
    REQUIRE(decode_normal(encode_normal(-n)) == -decode_normal(encode_normal(n)));
  }
  for (int code = 1; code <= lattice_codes; ++code)
    REQUIRE(decode_normal(NormalCode(opposite_codes - code)) == -decode_normal(NormalCode(code)));
}

TEST_CASE("codes turn and mirror with the directions, ties included") {
  // All 48 symmetries of the cube. Small integers tie often: any direction with two equal components may.
  const auto check_all = [](const glm::dvec3& n) {
    const glm::dvec3 decoded = decode_normal(encode_normal(n));
    constexpr int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
    for (const auto& order : orders)
      for (int signs = 0; signs < 8; ++signs) {
        const auto turned = [&](const glm::dvec3& v) {
          return glm::dvec3(signs & 1 ? -v[order[0]] : v[order[0]], signs & 2 ? -v[order[1]] : v[order[1]],
                            signs & 4 ? -v[order[2]] : v[order[2]]);
        };
        const double apart = glm::length(decode_normal(encode_normal(turned(n))) - turned(decoded));
        if (!(apart < 1e-14)) {
          UNSCOPED_INFO("(" << n.x << ", " << n.y << ", " << n.z << ")");
          REQUIRE(apart < 1e-14);
        }
      }
  };
  int between = 0;
  for (int x = 0; x <= 60; ++x)
    for (int y = 0; y <= x; ++y)
      for (int z = 0; z <= y; ++z) {
        check_all({x, y, z});
        between += encode_normal({x, y, z}) < first_above;
      }
  CHECK(between > 100);  // there were ties
  std::mt19937_64 random(4);
  std::uniform_int_distribution<int> byte(-255, 255);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 20000; ++trial) {
    check_all({byte(random), byte(random), byte(random)});
    check_all({normal(random), normal(random), normal(random)});
    const double twice = normal(random);
    check_all({twice, twice, normal(random)});
  }
}

TEST_CASE("the largest angular error is 0.57 degrees") {
  double worst = 0, sum = 0;
  int count = 0;
  const auto measure = [&](const glm::dvec3& n) {
    const double error = degrees_between(n, decode_normal(encode_normal(n)));
    worst = std::max(worst, error);
    sum += error;
    ++count;
  };
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 1000000; ++trial) measure({normal(random), normal(random), normal(random)});
  // The planes on which two components are alike.
  for (int k = 0; k <= 100000; ++k) measure({k * 1e-5, k * 1e-5, 1 - 1e-5 * k});
  // A regular sweep of one octant with its borders, where faces meet.
  for (int i = 0; i <= 600; ++i)
    for (int j = 0; i + j <= 600; ++j) measure(glm::dvec3(i, j, 600 - i - j));
  INFO("worst " << worst << " mean " << sum / count);
  REQUIRE(worst < 0.57);
  REQUIRE(worst > 0.49);  // 65018 directions cannot do better
  REQUIRE(sum / count < 0.31);
}

TEST_CASE("any length encodes alike; zero and what is not finite have no normal") {
  const glm::dvec3 n{0.3, -0.5, 0.2};
  const auto code = encode_normal(n);
  for (const double scale : {1e-300, 1e-150, 1e-20, 1e20, 1e150, 1e307})
    REQUIRE(encode_normal(n * scale) == code);
  REQUIRE(encode_normal({0, 0, 5e-324}) == encode_normal({0, 0, 1}));
  REQUIRE(encode_normal({1e308, 1e308, 1e308}) == encode_normal({1, 1, 1}));
  REQUIRE(encode_normal({1e-320, 1, 0}) == encode_normal({0, 1, 0}));
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double nan_value = std::numeric_limits<double>::quiet_NaN();
  for (const glm::dvec3 bad : {glm::dvec3(0, 0, 0), glm::dvec3(-0.0, 0, 0), glm::dvec3(nan_value, 1, 1),
                               glm::dvec3(1, nan_value, 1), glm::dvec3(1, 1, -infinity)})
    REQUIRE(encode_normal(bad) == no_normal);
}
