#include "classify/phong.hpp"

#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "classify/phong.cpp"
#include <fmt/format.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "ringsplat/base/error.hpp"

#ifndef RINGSPLAT_PHONG_ONCE
#define RINGSPLAT_PHONG_ONCE
namespace ringsplat {
namespace {

/// Number of normals lit together.
constexpr std::size_t block = 64;

/// Clamps to the largest float, so that 0 times a scale stays 0.
constexpr float most = std::numeric_limits<float>::max();

struct NormalBlock {
  const float *x, *y, *z;
};

struct Lighting {
  glm::vec3 light, viewer;  ///< unit directions
  float light_viewer;       ///< cosine between them
  float ambient, diffuse;
  float faint;  ///< up to this cosine the highlight is less than half a step of a 16-bit colour
};

/// Cosines between the mirrored light and the viewer; 0 where no highlight is seen.
using Mirrored = float[block];

}  // namespace
}  // namespace ringsplat
#endif

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Computes a block's scales; true when some highlights are not faint.
bool LightBlock(const NormalBlock& n, const Lighting& lighting, float* scales, Mirrored& mirrored) {
  const hn::CappedTag<float, block> d;
  const auto cosine = [&](std::size_t k, const glm::vec3& direction) {
    const auto along = [&](const float* axis, float part) {
      return hn::Mul(hn::LoadU(d, axis + k), hn::Set(d, part));
    };
    return hn::Add(hn::Add(along(n.x, direction.x), along(n.y, direction.y)), along(n.z, direction.z));
  };
  const auto faint = hn::Set(d, lighting.faint), ambient = hn::Set(d, lighting.ambient),
             diffuse = hn::Set(d, lighting.diffuse), light_viewer = hn::Set(d, lighting.light_viewer);
  auto brightest = hn::Zero(d);
  for (std::size_t k = 0; k < block; k += hn::Lanes(d)) {
    const auto facing_light = cosine(k, lighting.light), facing_viewer = cosine(k, lighting.viewer);
    // A surface in a volume has no inside: n and −n are lit alike, and a highlight needs light and viewer on
    // the same side.
    const auto same_side = hn::Mul(facing_light, facing_viewer),
               lobe = hn::Sub(hn::Add(same_side, same_side), light_viewer);
    const auto seen = hn::IfThenElseZero(hn::Gt(same_side, hn::Zero(d)), lobe);
    brightest = hn::Max(brightest, seen);
    hn::StoreU(seen, d, mirrored + k);
    const auto scale = hn::Add(ambient, hn::Mul(diffuse, hn::Abs(facing_light)));
    hn::StoreU(hn::Min(scale, hn::Set(d, most)), d, scales + k);
  }
  return !hn::AllFalse(d, hn::Gt(brightest, faint));
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {
namespace {

HWY_EXPORT(LightBlock);

glm::dvec3 unit_direction(const glm::dvec3& v, const char* what) {
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest > 0) || !std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z))
    throw InputError(fmt::format("the direction towards the {} is zero or not finite", what),
                     "give a world direction, for example 0 -1 0");
  return glm::normalize(v / largest);
}

void check(const PhongMaterial& m) {
  for (const double v : {m.ambient, m.diffuse, m.specular, m.exponent})
    if (!std::isfinite(v) || v < 0)
      throw InputError(fmt::format("Phong material {} {} {} {} is negative or not finite", m.ambient,
                                   m.diffuse, m.specular, m.exponent),
                       "give ambient, diffuse, specular and exponent from 0 up");
}

float to_float(double v) { return static_cast<float>(std::min(v, double(most))); }

/// One code of each two opposite directions, and no_normal.
constexpr std::size_t half_codes = opposite_codes / 2 + 1;
/// Rounded up to whole blocks.
constexpr std::size_t table_size = (half_codes + block - 1) / block * block;

/// Decoded normals of these codes, made once: tables are made anew for every view.
struct Normals {
  std::vector<float> x, y, z;
};
const Normals& all_normals() {
  static const Normals normals = [] {
    Normals decoded;
    for (auto* axis : {&decoded.x, &decoded.y, &decoded.z}) axis->assign(table_size, 0.0F);
    for (std::size_t code = 1; code < half_codes; ++code) {
      const glm::vec3 n(decode_normal(NormalCode(code)));
      decoded.x[code] = n.x;
      decoded.y[code] = n.y;
      decoded.z[code] = n.z;
    }
    return decoded;
  }();
  return normals;
}

}  // namespace

PhongTable::PhongTable(const PhongMaterial& material, const glm::dvec3& to_light,
                       const glm::dvec3& to_viewer) {
  check(material);
  const glm::dvec3 light = unit_direction(to_light, "light"), viewer = unit_direction(to_viewer, "viewer");
  const float specular = to_float(material.specular), exponent = to_float(material.exponent);
  const Lighting lighting{light,
                          viewer,
                          float(glm::dot(light, viewer)),
                          to_float(material.ambient),
                          to_float(material.diffuse),
                          exponent > 0 ? std::pow(1e-6F, 1.0F / exponent) : 0.0F};
  scales_.resize(table_size);
  highlights_.resize(table_size);
  const Normals& n = all_normals();
  for (std::size_t first = 0; first < table_size; first += block) {
    Mirrored mirrored;
    float* scales = &scales_[first];
    // Blocks without a highlight, which are most, need no powers.
    if (!HWY_DYNAMIC_DISPATCH(LightBlock)({&n.x[first], &n.y[first], &n.z[first]}, lighting, scales,
                                          mirrored))
      continue;
    for (std::size_t k = 0; k < block; ++k) {
      if (!(mirrored[k] > lighting.faint)) continue;
      scales[k] = -scales[k];
      highlights_[first + k] = specular * std::pow(std::min(mirrored[k], 1.0F), exponent);
    }
  }
  scales_[no_normal] = 1;
  highlights_[no_normal] = 0;
}

}  // namespace ringsplat
#endif
