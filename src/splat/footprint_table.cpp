#include "splat/footprint_table.hpp"

#include <algorithm>
#include <cmath>

#include "splat/encode.hpp"

namespace ringsplat {

namespace {

constexpr std::size_t most_floats = std::size_t{4} << 20;
constexpr std::size_t widest_vector = 16;  ///< floats

void fill_row(const Footprint& footprint, std::int64_t reach_x, double y, double centre_x, float* weights,
              PixelRun& covered) {
  for (std::int64_t x = -reach_x; x <= reach_x + 1; ++x) {
    const double dx = static_cast<double>(x) - centre_x;
    const double q = 1 + footprint.d * dx * dx + footprint.e * dx * y + footprint.f * y * y;
    if (!(q > 0)) continue;
    weights[x + reach_x] = static_cast<float>(q * q);
    const auto at = static_cast<std::int32_t>(x);
    covered.include(at, at + 1);
  }
}

}  // namespace

std::size_t FootprintTable::phase_of(float a, float b) const {
  const auto nearest = [&](double centre) {
    return static_cast<std::size_t>(std::clamp(centre * phases, 0.0, phases - 0.5));
  };
  const auto fa = static_cast<double>(a), fb = static_cast<double>(b);
  return nearest(y_of_a * fa + y_of_b * fb) * static_cast<std::size_t>(phases) +
         nearest(x_of_a * fa + x_of_b * fb);
}

FootprintTable make_footprint_table(const Footprint& footprint, int phases) {
  const auto reach = kernel_reach(footprint);
  FootprintTable table;
  table.reach_x = reach.x;
  table.reach_y = reach.y;
  table.row = static_cast<std::size_t>(2 * reach.x + 2) + widest_vector;
  while (phases > 1 &&
         static_cast<std::size_t>(phases) * static_cast<std::size_t>(phases) * table.rows() * table.row >
             most_floats)
    --phases;
  table.phases = phases;

  const double determinant = 4 * footprint.d * footprint.f - footprint.e * footprint.e;
  table.x_of_a = -2 * footprint.f / determinant;
  table.x_of_b = table.y_of_a = footprint.e / determinant;
  table.y_of_b = -2 * footprint.d / determinant;

  const std::size_t all = static_cast<std::size_t>(phases) * static_cast<std::size_t>(phases);
  table.weights.assign(all * table.rows() * table.row, 0.0F);
  table.covered.resize(all * table.rows());
  std::size_t at = 0;
  for (int j = 0; j < phases; ++j)
    for (int i = 0; i < phases; ++i)
      for (std::int64_t y = -reach.y; y <= reach.y + 1; ++y, ++at)
        fill_row(footprint, reach.x, static_cast<double>(y) - (j + 0.5) / phases, (i + 0.5) / phases,
                 table.weights.data() + at * table.row, table.covered[at]);
  return table;
}

}  // namespace ringsplat
