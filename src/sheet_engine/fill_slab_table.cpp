#include "base/vector_config.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sheet_engine/fill_slab_table.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>

#include "sheet_engine/fill_slab_table.hpp"
#include "sheet_engine/lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace ringsplat::HWY_NAMESPACE {

/// The curve's integrals relative to those at a row's front value, so that floats keep the digits of what
/// lies near it.
struct CurveRow {
  static constexpr std::size_t nodes = SlabTable::Curve::nodes;
  std::array<float, nodes> value, extinction, red, green, blue;
};

void RelativeTo(const std::vector<double>& all, int node, std::array<float, CurveRow::nodes>& out) {
  const double here = all[std::size_t(node)];
  for (std::size_t n = 0; n < out.size(); ++n) out[n] = static_cast<float>(all[n] - here);
}

/// Entries front, back ... back + lanes - 1; `low` and `high` get their halves.
HWY_INLINE void FillLanes(const CurveRow& row, int front, int back, float length, std::int32_t* low,
                          std::int32_t* high) {
  constexpr int pieces = SlabTable::nodes_an_entry;
  HWY_ALIGN std::int32_t way[lanes];
  for (int l = 0; l < lanes; ++l) way[l] = std::min(back + l, TableAxis::last) - front;
  const I step = load(way), first = set_int(front * pieces);
  const F none = set(0.0F), one = set(1.0F);
  const F whole = gather(row.value.data(), add(first, mul(step, set_int(pieces))));
  const F over = div(one, whole), density = mul(set(length), over);
  F hidden = none, red = none, green = none, blue = none, moment = none, square = none;
  F at = none, extinction = none, emitted_red = none, emitted_green = none, emitted_blue = none;
  for (int piece = 1; piece <= pieces; ++piece) {
    const I node = add(first, mul(step, set_int(piece)));
    const F next = mul(gather(row.value.data(), node), over),
            next_extinction = gather(row.extinction.data(), node);
    const F opacity = opacity_of(mul(next_extinction, density)), seen = max(sub(opacity, hidden), none);
    const F change = sub(next_extinction, extinction);
    const F share = only(greater(abs(change), none), div(seen, change));
    const auto mix = [&](const auto& integral, F& before, F& sum) {
      const F here = gather(integral.data(), node);
      sum = fma(share, sub(here, before), sum);
      before = here;
    };
    mix(row.red, emitted_red, red);
    mix(row.green, emitted_green, green);
    mix(row.blue, emitted_blue, blue);
    const F middle = mul(set(0.5F), add(at, next)), extent = sub(next, at);
    moment = fma(seen, middle, moment);
    square = fma(seen, fma(middle, middle, mul(mul(extent, extent), set(1.0F / 12))), square);
    hidden = add(hidden, seen);
    at = next;
    extinction = next_extinction;
  }
  const M visible = greater(hidden, none);
  const F scale = only(visible, div(one, hidden)), centroid = mul(moment, scale);
  const F spread = root(max(sub(mul(square, scale), mul(centroid, centroid)), none));
  const auto coded = [&](F value, float most) {
    return to_int(only(visible, mul(min(max(value, none), one), set(most))));
  };
  const I g = coded(mul(green, scale), 1023);
  store_ints(
      either(either(coded(root(min(hidden, one)), 65535), up<16>(coded(mul(red, scale), 1023))), up<26>(g)),
      low);
  store_ints(either(either(down<6>(g), up<4>(coded(mul(blue, scale), 1023))),
                    either(up<14>(coded(centroid, 255)), up<22>(coded(min(spread, set(0.49F)), 127)))),
             high);
}

void FillSlabTable(const SlabTable::Curve& curve, double length, std::uint64_t* entries) {
  auto row = std::make_unique<CurveRow>();
  for (int front = 0; front < TableAxis::entries; ++front) {
    const int node = front * SlabTable::nodes_an_entry;
    RelativeTo(curve.value, node, row->value);
    RelativeTo(curve.extinction, node, row->extinction);
    RelativeTo(curve.red, node, row->red);
    RelativeTo(curve.green, node, row->green);
    RelativeTo(curve.blue, node, row->blue);
    for (int back = 0; back < TableAxis::entries; back += lanes) {
      HWY_ALIGN std::int32_t low[lanes], high[lanes];
      FillLanes(*row, front, back, static_cast<float>(length), low, high);
      std::uint64_t* out = entries + std::size_t(front) * TableAxis::entries + std::size_t(back);
      for (int l = 0; l < lanes; ++l)
        out[l] = std::uint64_t(std::uint32_t(high[l])) << 32 | std::uint32_t(low[l]);
    }
  }
}

}  // namespace ringsplat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ringsplat {

HWY_EXPORT(FillSlabTable);

void fill_slab_table(const SlabTable::Curve& curve, double length, std::span<std::uint64_t> entries) {
  HWY_DYNAMIC_DISPATCH(FillSlabTable)(curve, length, entries.data());
}

std::uint64_t packed(const SlabEntry& e) {
  const auto coded = [](double value, double most) {
    return static_cast<std::uint64_t>(std::lround(std::clamp(value, 0.0, 1.0) * most));
  };
  return coded(std::sqrt(e.opacity), 65535) | coded(e.red, 1023) << 16 | coded(e.green, 1023) << 26 |
         coded(e.blue, 1023) << 36 | coded(e.centroid, 255) << 46 |
         coded(std::min(e.spread, 0.49), 127) << 54;
}

double extinction(double opacity) {
  constexpr double most = 1e4;
  return opacity < 1 ? std::min(-std::log1p(-opacity), most) : most;
}

std::uint64_t uniform_slab(double extinction, const glm::dvec3& colour, double length) {
  const double x = extinction * length, opacity = -std::expm1(-x);
  if (!(opacity > 0)) return 0;
  double centroid = 0.5, spread = std::sqrt(1.0 / 12);
  if (x > 1e-3) {
    const double left = std::exp(-x) / opacity;
    centroid = 1 / x - left;
    const double square = 2 / (x * x) - left * (1 + 2 / x);
    spread = std::sqrt(std::max(0.0, square - centroid * centroid));
  }
  return packed({opacity, colour.r, colour.g, colour.b, centroid, spread});
}

}  // namespace ringsplat
#endif
