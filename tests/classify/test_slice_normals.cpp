#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "classify/normals.hpp"
#include "classify/type_of.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();
constexpr double quantisation = 0.57;  // degrees

template <class T>
struct Volume {
  Grid grid;
  std::vector<T> voxels;

  explicit Volume(const glm::ivec3& dims) {
    grid.dims = dims;
    grid.type = type_of<T>();
    voxels.resize(std::size_t(grid.voxels()));
  }
  T& at(int x, int y, int z) { return voxels[index(x, y, z)]; }
  /// Each voxel is `value(x, y, z)`.
  template <class F>
  void fill(F&& value) {
    for (int z = 0; z < grid.dims.z; ++z)
      for (int y = 0; y < grid.dims.y; ++y)
        for (int x = 0; x < grid.dims.x; ++x) at(x, y, z) = T(value(x, y, z));
  }
  std::vector<NormalCode> normals() const {
    const std::size_t slice = std::size_t(grid.dims.x) * std::size_t(grid.dims.y);
    std::vector<NormalCode> codes(voxels.size());
    const auto bytes = [&](int z) {
      return z >= 0 && z < grid.dims.z
                 ? reinterpret_cast<const std::byte*>(voxels.data() + slice * std::size_t(z))
                 : nullptr;
    };
    for (int z = 0; z < grid.dims.z; ++z)
      slice_normals(grid, bytes(z - 1), bytes(z), bytes(z + 1),
                    {codes.data() + slice * std::size_t(z), slice});
    return codes;
  }
  std::size_t index(int x, int y, int z) const {
    return (std::size_t(z) * std::size_t(grid.dims.y) + std::size_t(y)) * std::size_t(grid.dims.x) +
           std::size_t(x);
  }
};

double degrees_between(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / std::numbers::pi;
}

/// The normal by the header's rules, in long double and without shortcuts.
template <class T>
std::optional<glm::dvec3> reference(Volume<T>& v, const glm::ivec3& p) {
  const auto value = [&](const glm::ivec3& q) -> std::optional<long double> {
    for (int k = 0; k < 3; ++k)
      if (q[k] < 0 || q[k] >= v.grid.dims[k]) return std::nullopt;
    const T value_there = v.at(q.x, q.y, q.z);
    if (!std::isfinite(double(value_there))) return std::nullopt;
    return value_there;
  };
  const auto centre = value(p);
  if (!centre) return std::nullopt;
  long double derivative[3], largest = 0;
  for (int k = 0; k < 3; ++k) {
    glm::ivec3 before = p, after = p;
    --before[k];
    ++after[k];
    const auto b = value(before), a = value(after);
    derivative[k] = (a.value_or(*centre) - b.value_or(*centre)) / (a && b ? 2 : 1) / v.grid.spacing[k];
    largest = std::max(largest, std::abs(derivative[k]));
  }
  if (largest == 0) return std::nullopt;
  const glm::dvec3 scaled{double(derivative[0] / largest), double(derivative[1] / largest),
                          double(derivative[2] / largest)};
  return glm::normalize(-(glm::transpose(glm::inverse(v.grid.direction)) * scaled));
}

template <class T>
void require_reference(Volume<T>& v) {
  const auto codes = v.normals();
  for (int z = 0; z < v.grid.dims.z; ++z)
    for (int y = 0; y < v.grid.dims.y; ++y)
      for (int x = 0; x < v.grid.dims.x; ++x) {
        INFO("voxel " << x << ' ' << y << ' ' << z);
        const auto expected = reference(v, {x, y, z});
        const NormalCode code = codes[v.index(x, y, z)];
        REQUIRE((code == no_normal) == !expected);
        if (expected) REQUIRE(degrees_between(decode_normal(code), *expected) < quantisation);
      }
}

glm::dmat3 turned() { return glm::dmat3(glm::rotate(glm::dmat4(1.0), 0.7, glm::dvec3(1, 2, -0.5))); }

}  // namespace

TEST_CASE("a linear field has one normal everywhere, down its slope in the world, borders included") {
  Volume<double> v({7, 6, 5});
  v.grid.spacing = {0.5, 2, 3};
  v.grid.direction = turned();
  const glm::dvec3 slope{0.3, -1.1, 0.7};
  v.fill([&](int x, int y, int z) {
    return 10 + glm::dot(slope, v.grid.direction * (v.grid.spacing * glm::dvec3(x, y, z)));
  });
  const auto expected = encode_normal(-slope);
  for (const auto code : v.normals()) REQUIRE(code == expected);

  // Values that are not finite do not change the normals of the other voxels, whose field is linear.
  v.at(3, 3, 2) = nan_value;
  v.at(4, 2, 2) = infinity;
  v.at(0, 0, 0) = -infinity;
  const auto codes = v.normals();
  for (std::size_t i = 0; i < codes.size(); ++i)
    REQUIRE(codes[i] == (std::isfinite(v.voxels[i]) ? expected : no_normal));
}

TEST_CASE("oblique axes: the gradient transforms by the inverse transpose") {
  Volume<float> v({5, 5, 5});
  v.grid.direction = glm::dmat3(1, 0, 0, 0, 1, 0, 0, std::sin(0.4), std::cos(0.4));  // a tilted gantry
  v.grid.spacing = {1, 1, 2};
  const glm::dvec3 slope{1, 2, -1};
  v.fill([&](int x, int y, int z) {
    return glm::dot(slope, v.grid.direction * (v.grid.spacing * glm::dvec3(x, y, z)));
  });
  for (const auto code : v.normals()) REQUIRE(degrees_between(decode_normal(code), -slope) < quantisation);
}

TEMPLATE_TEST_CASE("random volumes of every type agree with the rules", "", std::int8_t, std::uint8_t,
                   std::int16_t, std::uint16_t, std::int32_t, std::uint32_t, float, double) {
  using T = TestType;
  std::mt19937_64 random(4);
  for (const glm::ivec3 dims : {glm::ivec3(9, 8, 7), glm::ivec3(1, 5, 4), glm::ivec3(5, 1, 2),
                                glm::ivec3(2, 3, 1), glm::ivec3(1, 1, 1), glm::ivec3(3, 3, 3)}) {
    Volume<T> v(dims);
    v.grid.spacing = {1.5, 0.4, 1.0};
    v.grid.direction = turned();
    for (auto& voxel : v.voxels) {
      if constexpr (std::is_floating_point_v<T>) {
        const double values[] = {nan_value, infinity, -infinity, 0, 1, -2.5, 1e-3, 7};
        voxel = T(values[random() % 8]);
      } else {
        voxel = T(random() % 3 ? random() : 5);
      }
    }
    require_reference(v);
  }
}

TEMPLATE_TEST_CASE("the extreme values of a type neither overflow nor vanish", "", std::int8_t, std::uint8_t,
                   std::int16_t, std::uint16_t, std::int32_t, std::uint32_t, float, double) {
  using T = TestType;
  std::mt19937_64 random(8);
  Volume<T> v({6, 5, 4});
  for (auto& voxel : v.voxels)
    voxel = random() % 2 ? std::numeric_limits<T>::lowest() : std::numeric_limits<T>::max();
  require_reference(v);
}

TEST_CASE("denormal and huge differences have normals") {
  for (const double size : {1e-310, 1e-200, 1e-60, 1e60, 1e200, 1e307}) {
    Volume<double> v({5, 5, 5});
    std::mt19937_64 random(6);
    std::uniform_real_distribution<double> number(-1, 1);
    for (auto& voxel : v.voxels) voxel = size * number(random);
    INFO(size);
    require_reference(v);
  }
  Volume<float> v({4, 4, 4});
  v.fill([](int x, int, int) { return 1e-42F * float(x); });
  for (const auto code : v.normals()) REQUIRE(decode_normal(code) == glm::dvec3(-1, 0, 0));
}

TEST_CASE("spacings from 1e-12 to 1e12 keep the direction") {
  Volume<std::uint16_t> v({4, 4, 4});
  std::mt19937_64 random(3);
  for (auto& voxel : v.voxels) voxel = std::uint16_t(random());
  const auto expected = v.normals();
  for (const double size : {1e-12, 1e12}) {
    v.grid.spacing = glm::dvec3(size);
    REQUIRE(v.normals() == expected);
  }
  v.grid.spacing = {1e-12, 1e12, 1.0};
  require_reference(v);
}

TEMPLATE_TEST_CASE("an even volume has no normals", "", std::int8_t, std::uint8_t, std::int16_t,
                   std::uint16_t, std::int32_t, std::uint32_t, float, double) {
  Volume<TestType> v({5, 4, 3});
  std::fill(v.voxels.begin(), v.voxels.end(), TestType(100));
  for (const auto code : v.normals()) REQUIRE(code == no_normal);
}

TEST_CASE("a voxel among not-a-numbers has no normal") {
  Volume<float> v({3, 3, 3});
  std::fill(v.voxels.begin(), v.voxels.end(), float(nan_value));
  v.at(1, 1, 1) = 5;
  for (const auto code : v.normals()) REQUIRE(code == no_normal);
  v.at(2, 1, 1) = 3;  // one neighbour is enough
  REQUIRE(decode_normal(v.normals()[v.index(1, 1, 1)]) == glm::dvec3(1, 0, 0));
}

TEST_CASE("the normals of a ball point outward") {
  constexpr int n = 33;
  Volume<std::uint8_t> v({n, n, n});
  const glm::dvec3 centre(16);
  v.fill([&](int x, int y, int z) {
    return std::lround(std::clamp(255 - 14 * glm::distance(glm::dvec3(x, y, z), centre), 0.0, 255.0));
  });
  const auto codes = v.normals();
  int checked = 0;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const glm::dvec3 out = glm::dvec3(x, y, z) - centre;
        if (glm::length(out) < 6 || glm::length(out) > 15) continue;
        ++checked;
        REQUIRE(degrees_between(decode_normal(codes[v.index(x, y, z)]), out) < 5);  // 8 bits
      }
  REQUIRE(checked > 10000);
}
