#include "base/vector_config.hpp"
// After the header that says which instruction sets there are.
#include <hwy/targets.h>

#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <random>
#include <vector>

#include "classify/find_visible.hpp"
#include "classify/phong.hpp"
#include "classify/two_points.hpp"
#include "classify/type_of.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

/// Restricts Highway to one instruction set while it lives.
struct OneTarget {
  explicit OneTarget(std::int64_t target) { use(target); }
  ~OneTarget() { use(0); }
  static void use(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

constexpr ClassifiedSample grey{0.25F, 0.5F, 0.125F, 0.7F};

/// One sample, lit by its normal.
ClassifiedSample shade(const PhongTable& table, NormalCode normal, const ClassifiedSample& s) {
  const PhongTable::Entries entries = table.entries();
  const std::size_t place = PhongTable::place_of(normal);
  const float scale = std::abs(entries.scales[place]), add = entries.highlights[entries.highlight_of(place)];
  return {std::min(s.r * scale + add, 1.0F), std::min(s.g * scale + add, 1.0F),
          std::min(s.b * scale + add, 1.0F), s.opacity};
}

}  // namespace

TEST_CASE("a surface that faces light and viewer gets all three terms, one on edge the ambient one alone") {
  const PhongMaterial material{.ambient = 0.125, .diffuse = 0.5, .specular = 0.25, .exponent = 20};
  const PhongTable table(material, {0, 0, 5}, {0, 0, 2});
  const auto facing = shade(table, encode_normal({0, 0, 1}), grey);
  REQUIRE(facing.r == 0.25F * 0.625F + 0.25F);
  REQUIRE(facing.g == 0.5F * 0.625F + 0.25F);
  REQUIRE(facing.opacity == 0.7F);
  const auto edge = shade(table, encode_normal({1, 0, 0}), grey);
  REQUIRE(edge.r == 0.25F * 0.125F);
  REQUIRE(edge.b == 0.125F * 0.125F);
}

TEST_CASE("the table holds Phong's formula for every normal") {
  const PhongMaterial material;
  const glm::dvec3 light = glm::normalize(glm::dvec3(0.3, -1, 0.6)),
                   viewer = glm::normalize(glm::dvec3(-0.2, -1, 0.1));
  const PhongTable table(material, light * 7.0, viewer * 0.01);
  for (int code = 1; code <= 65018; code += 7) {
    const glm::dvec3 n = decode_normal(NormalCode(code));
    const double nl = glm::dot(n, light);
    const glm::dvec3 reflected = 2 * nl * n - light;
    const bool same_side = nl * glm::dot(n, viewer) > 0;
    const double highlight =
        same_side ? std::pow(std::max(0.0, glm::dot(reflected, viewer)), material.exponent) : 0.0;
    const double expected =
        0.5 * (material.ambient + material.diffuse * std::abs(nl)) + material.specular * highlight;
    REQUIRE(shade(table, NormalCode(code), {0.5F, 0, 0, 1}).r ==
            Approx(std::min(1.0, expected)).margin(1e-6));
  }
}

TEST_CASE("no highlight when light and viewer are on different sides") {
  const PhongMaterial shiny{.ambient = 0, .diffuse = 0, .specular = 1, .exponent = 4};
  const PhongTable table(shiny, {0, 0, 1}, {0, 0, -1});
  for (int code = 1; code <= 65018; code += 101) REQUIRE(shade(table, NormalCode(code), grey).r == 0.0F);
}

TEST_CASE("without a normal a sample stays as it is, bit for bit; colours are clamped to 1") {
  const PhongTable table({.ambient = 3, .diffuse = 1, .specular = 1, .exponent = 1}, {0, 0, 1}, {0, 0, 1});
  const auto unlit = shade(table, no_normal, {0.1F, 1.0F, 0.3F, 0.6F});
  REQUIRE(unlit.r == 0.1F);
  REQUIRE(unlit.g == 1.0F);
  REQUIRE(unlit.b == 0.3F);
  REQUIRE(unlit.opacity == 0.6F);
  REQUIRE(shade(table, encode_normal({0, 0, 1}), grey).g == 1.0F);
}

TEST_CASE("an exponent of 0 makes the highlight even; directions may have any length") {
  const PhongTable even({.ambient = 0, .diffuse = 0, .specular = 0.5, .exponent = 0}, {0, 0, 1}, {0, 0, 1});
  REQUIRE(shade(even, encode_normal({0, 0.1, 1}), grey).r == 0.5F);
  REQUIRE_NOTHROW(PhongTable({}, {0, 0, 1e-320}, {1e300, 0, 0}));
}

TEMPLATE_TEST_CASE("a row is shaded as its voxels are one by one, bit for bit, by every instruction set", "",
                   std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, float) {
  TransferFunction tf = two_points(0, 0, 100, 1);
  tf.colours = {{-20, {1, 0, 0}}, {50, {0.5, 1, 0}}, {120, {0, 0, 0.3}}};
  const Classifier classifier(tf, type_of<TestType>(), 1.3);
  std::mt19937 random(11);
  std::uniform_int_distribution<int> value(-30, 120);
  std::vector<TestType> values;
  while (values.size() < 3000) values.push_back(TestType(value(random)));
  std::vector<NormalCode> normals{no_normal, 65535, no_normal};
  while (normals.size() < values.size()) normals.push_back(NormalCode(random()));
  const auto* bytes = reinterpret_cast<const std::byte*>(values.data());
  const VoxelRow row{bytes, normals.data(), int(values.size())};
  const VisibleRow found = find_visible(classifier, bytes, int(values.size()));
  VisibleRow unlit = found;
  make_samples(classifier, row, nullptr, unlit);
  std::vector<std::uint32_t> columns;
  for (const VisibleBlock& block : found.blocks)
    for (std::uint32_t k = 0; k < 64; ++k)
      if (block.mask >> k & 1) columns.push_back(block.first + k);
  REQUIRE(columns.size() == found.visible);
  REQUIRE(found.visible > 1000);
  // The last one is beyond the largest float: 0 times the light must stay 0.
  for (const auto& material : {PhongMaterial{}, PhongMaterial{.ambient = 0.9, .specular = 3, .exponent = 2.5},
                               PhongMaterial{.ambient = 1e300}}) {
    const PhongTable table(material, {0.3, -1, 0.6}, {-0.2, -1, 0.1});
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      const OneTarget only(target);
      INFO(hwy::TargetName(target));
      VisibleRow lit = found;
      make_samples(classifier, row, &table, lit);
      for (std::uint32_t k = 0; k < found.visible; ++k) {
        const ClassifiedSample &before = unlit.samples[k], &after = lit.samples[k];
        const ClassifiedSample expected = shade(table, normals[columns[k]], before);
        REQUIRE(std::memcmp(&after, &expected, sizeof expected) == 0);
        REQUIRE((after.r <= 1 && after.opacity == before.opacity));
        if (before.b == 0 && normals[columns[k]] == no_normal) REQUIRE(after.b == 0);
      }
    }
  }
}
