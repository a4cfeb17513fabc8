#include <cmath>

#include "sheet_engine/fill_slab_table.hpp"
#include "sheet_engine/place_map.hpp"
#include "sheet_engine/slab_table.hpp"
#include "sheet_engine/transparent_values.hpp"
#include "support/catch.hpp"
#include "support/scenes.hpp"
#include "support/vector_targets.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

SlabEntry unpacked(std::uint64_t bits) {
  const auto part = [bits](int from, int count) {
    return double(bits >> from & ((std::uint64_t{1} << count) - 1));
  };
  return {std::pow(part(0, 16) / 65535, 2),
          part(16, 10) / 1023,
          part(26, 10) / 1023,
          part(36, 10) / 1023,
          part(46, 8) / 255,
          part(54, 6) / 127};
}

/// A slab in many pieces of one value each.
SlabEntry by_many_pieces(const TransferFunction& tf, double front, double back, double length) {
  constexpr int pieces = 20000;
  SlabEntry slab{};
  double through = 1, square = 0;
  for (int k = 0; k < pieces; ++k) {
    const double way = (k + 0.5) / pieces;
    const auto here = tf.evaluate(front + way * (back - front));
    const double opacity = 1 - std::pow(1 - here.opacity, length / pieces), added = through * opacity;
    slab.red += added * here.colour.r;
    slab.green += added * here.colour.g;
    slab.blue += added * here.colour.b;
    slab.centroid += added * way;
    square += added * way * way;
    through -= added;
  }
  slab.opacity = 1 - through;
  if (slab.opacity > 0) {
    for (double* part : {&slab.red, &slab.green, &slab.blue, &slab.centroid}) *part /= slab.opacity;
    slab.spread = std::sqrt(std::max(0.0, square / slab.opacity - slab.centroid * slab.centroid));
  }
  return slab;
}

TransferFunction steep() {
  TransferFunction tf;
  tf.colours = {{0.0, {1, 0, 0}}, {40.0, {0.2, 0.9, 0.3}}, {100.0, {0.1, 0.2, 1}}};
  tf.opacities = {{20.0, 0.0}, {35.0, 0.9}, {50.0, 0.3}, {60.0, 0.0}, {80.0, 0.0}, {100.0, 0.6}};
  return tf;
}

}  // namespace

TEST_CASE("a block counts as transparent up to a millionth before an end that is visible") {
  TransferFunction tf = steep();
  tf.opacities = {{40.0, 0.0}, {40.0, 0.5}, {60.0, 0.5}, {60.0, 0.0}};
  const TransparentValues transparent(tf);
  CHECK(transparent.holding(0, 40 - 1e-4) == 0);
  CHECK(transparent.holding(0, 40 - 1e-5) == TransparentValues::nowhere);
  CHECK(transparent.holding(60, 100) == 1);
}

TEST_CASE("entries are the slabs that many small pieces make") {
  const TransferFunction tf = steep();
  SlabTable table;
  table.make(tf, 0, 100, 0.6);
  const TableAxis& axis = table.axis();
  for (int front = 0; front < TableAxis::entries; front += 17)
    for (int back = 3; back < TableAxis::entries; back += 23) {
      const SlabEntry exact = by_many_pieces(tf, axis.value_at(front), axis.value_at(back), 0.6),
                      entry = unpacked(table.entries()[front * TableAxis::entries + back]);
      INFO("from " << axis.value_at(front) << " to " << axis.value_at(back));
      CHECK(std::abs(entry.opacity - exact.opacity) < 2e-3);
      if (exact.opacity < 0.01) continue;
      CHECK(std::abs(entry.red - exact.red) < 0.02);
      CHECK(std::abs(entry.green - exact.green) < 0.02);
      CHECK(std::abs(entry.blue - exact.blue) < 0.02);
      CHECK(std::abs(entry.centroid - exact.centroid) < 0.07);
      CHECK(std::abs(entry.spread - exact.spread) < 0.07);
    }
}

TEST_CASE("every vector instruction set fills the same table") {
  SlabTable best;
  best.make(steep(), 0, 100, 0.7);
  for (const std::string& target : vector_targets()) {
    INFO(target);
    use_vector_target(target);
    SlabTable table;
    table.make(steep(), 0, 100, 0.7);
    use_vector_target("");
    CHECK(std::equal(best.entries(), best.entries() + TableAxis::entries * TableAxis::entries,
                     table.entries()));
  }
}

TEST_CASE("an axis spends entries on what is narrow, and place and value are inverse") {
  TransferFunction tf;
  tf.colours = {{0, {1, 1, 1}}, {1, {1, 1, 1}}};
  tf.opacities = {{30010, 0.0}, {30011, 0.6}, {30013, 0.0}};
  const TableAxis narrow(tf, 0, 65535);
  CHECK(!narrow.even());
  CHECK(narrow.place_of(30013) - narrow.place_of(30010) > 60);
  CHECK(std::abs(narrow.place_of(65535) - TableAxis::last) < 1e-6);
  for (const double place : {0.0, 1.5, 100.0, 200.25, 255.0})
    CHECK(std::abs(narrow.place_of(narrow.value_at(place)) - place) < 1e-6);
  CHECK(TableAxis(ramp(0, 65535, 0.6), 0, 65535).even());
}

TEST_CASE("transparent values are those below, above and between all visible ones") {
  const TransparentValues values(steep());
  REQUIRE(values.intervals().size() == 2);
  CHECK(values.holding(-5, 20) == 0);
  CHECK(values.holding(-5, 20.001) == TransparentValues::nowhere);
  CHECK(values.holding(61, 80) == 1);
  CHECK(values.holding(10, 70) == TransparentValues::nowhere);
  CHECK(values.holding(100, 101) == TransparentValues::nowhere);
  // At a jump the value has the opacity behind it.
  const TransparentValues jump(constant_opacity(0.5, 10));
  CHECK(jump.holding(0, 9.999) == 0);
  CHECK(jump.holding(0, 10) == TransparentValues::nowhere);
}

TEST_CASE("only the widest gaps are kept") {
  TransferFunction tf;
  tf.colours = {{0, {1, 1, 1}}, {1, {1, 1, 1}}};
  for (int k = 0; k < 10; ++k) {
    const double start = 10 * k;
    tf.opacities.insert(tf.opacities.end(),
                        {{start, 0.0}, {start + 1, 0.5}, {start + 2, 0.0}, {start + 9 - 0.5 * k, 0.0}});
    tf.opacities.push_back({start + 9.5 - 0.5 * k, 0.5});
  }
  const TransparentValues values(tf);
  CHECK(values.intervals().size() <= TransparentValues::most);
  CHECK(values.holding(3, 8.9) != TransparentValues::nowhere);
}

TEST_CASE("of whole numbers that count as transparent interpolation makes nothing visible") {
  SheetFrame frame;
  frame.shown.transfer_function = steep();
  frame.transparent = TransparentValues(steep());
  frame.geometry.grid.type = ScalarType::uint8;
  SlabTable table;
  table.make(steep(), 0, 100, 1);
  const ValueScale scale = value_scale(frame, 0, 100);
  const PlaceMap map = place_map(frame, scale, table.axis());
  REQUIRE(map.gap_count == 1);
  const auto [gap_low, gap_high] = map.number_gaps[0];
  const auto visible = [&](float number) {
    const float place = place_of_number(map, number);
    return place > map.visible_low && place < map.visible_high &&
           !(place >= map.gaps[0].low && place <= map.gaps[0].high);
  };
  const auto number = [&](double value) { return int(std::lround(scale.code.of(value))); };
  // All but the ends, whose interpolation is rounded.
  CHECK(map.transparent.low == number(20) - 1);
  CHECK(map.transparent.high == INT16_MAX);
  CHECK(gap_low == number(60) + 1);
  CHECK(gap_high == number(80) - 1);
  for (int of_thirds = 3 * number(0); of_thirds <= 3 * number(100); ++of_thirds) {
    const float between = float(of_thirds) * (1.0F / 3);
    if (between <= float(map.transparent.low) || (between >= float(gap_low) && between <= float(gap_high)))
      CHECK(!visible(between));
  }
  CHECK(visible(float(number(20) + 1)));
  CHECK(visible(float(number(60) - 1)));
}
