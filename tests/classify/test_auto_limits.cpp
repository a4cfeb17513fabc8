// The limits at which "auto" decides one way or the other, by values on either side of each.
#include <cmath>

#include "classify/auto_preset.hpp"
#include "classify/value_shape.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat;

namespace {

/// Statistics of bins alone, of a cube of `side` voxels.
ValueStatistics statistics_of(const Bins& bins, int side = 64) {
  ValueStatistics s;
  s.grid.type = ScalarType::float32;
  s.grid.dims = glm::ivec3(side);
  s.range.low = bins.front().low;
  s.range.high = bins.back().high;
  s.histogram = Histogram(s.range.low, s.range.high, 256);
  s.bins = bins;
  return s;
}

/// Whole values from 0 on, so many voxels each.
Bins values(const std::vector<std::uint64_t>& counts) {
  Bins bins;
  for (std::size_t k = 0; k < counts.size(); ++k) bins.push_back({double(k), double(k), counts[k]});
  return bins;
}

/// Bins one wide from `low` to `high`, `count` voxels each and `more` in the one at `at`.
Bins even_but_for(int low, int high, std::uint64_t count, int at, std::uint64_t more) {
  Bins bins;
  for (int v = low; v < high; ++v) bins.push_back({double(v), v + 1.0, count + (v == at ? more : 0)});
  return bins;
}

bool chosen(const Bins& bins, const char* what) {
  return says(choose_function(statistics_of(bins)).why, what);
}

}  // namespace

TEST_CASE("auto scales opacities until a way through the object has an optical depth of 1.5 to 25") {
  const Bins bins = even_but_for(0, 100, 100, 0, 30000);
  const auto depth = [&](int side, double& densest) {
    const TransferFunction tf = choose_function(statistics_of(bins, side)).function;
    double sum = 0, visible = 0;
    for (const ValueBin& bin : bins) {
      const double opacity = tf.evaluate(bin.middle()).opacity;
      if (!(opacity > 0)) continue;
      visible += double(bin.count);
      sum -= std::log1p(-opacity) * double(bin.count);
    }
    densest = tf.evaluate(100).opacity;
    return sum / visible * side * std::cbrt(visible / count_of(bins));
  };
  double densest = 0;
  CHECK(depth(4, densest) == Approx(1.5).epsilon(0.02));
  CHECK(densest > 0.75);
  const double usual = depth(64, densest);
  CHECK(usual > 1.5);
  CHECK(usual < 25);
  CHECK(densest == Approx(0.7));
  CHECK(depth(4000, densest) == Approx(25).epsilon(0.02));
  CHECK(densest < 0.65);
}

TEST_CASE("a field has both signs about zero when its median is within a tenth of its largest magnitude") {
  const auto diverging = [](int low, int high, int median) {
    return chosen(even_but_for(low, high, 100, median, 30000), "diverging");
  };
  CHECK(diverging(-100, 100, 8));  // the median is its bin's upper end
  CHECK_FALSE(diverging(-100, 100, 11));
  CHECK(diverging(-100, 100, -10));
  CHECK_FALSE(diverging(-100, 100, -13));
  // The smaller side reaches a quarter of the larger one.
  CHECK(diverging(-30, 100, 0));
  CHECK_FALSE(diverging(-20, 100, 0));
  CHECK(diverging(-100, 30, 0));
  CHECK_FALSE(diverging(-100, 20, 0));
}

TEST_CASE("a field has both signs when the rarer one has a tenth as many voxels as the other") {
  const auto diverging = [](std::uint64_t negative, std::uint64_t positive) {
    Bins bins;
    for (int v = -100; v < 100; ++v)
      bins.push_back({double(v), v + 1.0, v == 0 ? 40000 : v < 0 ? negative : positive});
    return chosen(bins, "diverging");
  };
  CHECK(diverging(11, 100));
  CHECK_FALSE(diverging(9, 100));
  CHECK(diverging(100, 11));
  CHECK_FALSE(diverging(100, 9));
}

TEST_CASE("positive values are logarithmic when a twentieth or less is above a tenth of the largest") {
  const auto logarithmic = [](std::uint64_t large) {
    return chosen({{1, 1.5, 300},
                   {2, 3, 6000},
                   {10, 20, 1500},
                   {30, 40, 1000},
                   {100, 200, 600},
                   {300, 400, 600 - large},
                   {5000, 6000, large - 20},
                   {9000, 9500, 20}},
                  "logarithmic");
  };
  CHECK(logarithmic(490));
  CHECK_FALSE(logarithmic(510));
}

TEST_CASE("a bin counts as within from the low end on and below the high one") {
  CHECK(share_within(values({1, 2, 4, 8}), 1, 3) == Approx(6.0 / 15));
}

TEST_CASE("voxels are outliers that lie further away than fifty times the others' span") {
  for (const double gap : {490.0, 510.0})
    for (const bool above : {false, true}) {
      Bins bins = even_but_for(0, 10, 1000, 0, 0);
      const double far = above ? 10 + gap : -gap;
      bins.insert(above ? bins.end() : bins.begin(), {far, far, 1});
      const KeptBins kept = without_outliers(bins);
      CHECK((above ? kept.last == 9 : kept.first == 1) == (gap > 500));
    }
}

TEST_CASE("values are Hounsfield units when there is air, soft tissue, and less between them") {
  const auto ct = [](std::uint64_t air, std::uint64_t between, std::uint64_t soft, double lowest = -1024) {
    return chosen({{lowest, lowest + 1, 1000},
                   {-895, -890, air},
                   {-500, -300, between},
                   {0, 100, soft},
                   {500, 600, 10},
                   {1100, 1200, 10}},
                  "CT in Hounsfield units (by its range");
  };
  CHECK(ct(4000, 900, 1000));
  CHECK_FALSE(ct(4000, 1100, 1000));
  CHECK_FALSE(ct(4000, 100, 90));  // under three hundredths of soft tissue
  CHECK(ct(4000, 900, 1000, -901));
  CHECK_FALSE(ct(4000, 900, 1000, -899));
}

TEST_CASE("a fill value is that of a thousandth of all voxels") {
  for (const std::uint64_t count : {9U, 11U}) {
    Bins bins{{-9999, -9999, count}};
    for (int k = 0; k < 10; ++k) bins.push_back({100.0 * k, 100.0 * (k + 1), 999});
    CHECK(data_of(statistics_of(bins)).fill_below.has_value() == (count > 10));
  }
}

TEST_CASE("a value at one end is a fill value from a gap on, a known one from a smaller gap") {
  const auto fill = [](double value, double gap, bool above) {
    constexpr double span = 1000;
    Bins bins;
    const double first = above ? value - gap - span : value + gap;
    for (int k = 0; k < 10; ++k) bins.push_back({first + 100 * k, first + 100 * (k + 1), 1000});
    bins.insert(above ? bins.end() : bins.begin(), {value, value, 500});
    const Data d = data_of(statistics_of(bins));
    CHECK((above ? d.fill_below : d.fill_above) == std::nullopt);
    return (above ? d.fill_above : d.fill_below) == value;
  };
  for (const auto& [value, above] : {std::pair{-9999.0, false}, {9999.0, true}}) {
    CHECK(fill(value, 110, above));
    CHECK_FALSE(fill(value, 90, above));
  }
  for (const bool above : {false, true}) {
    CHECK(fill(5000, 2100, above));
    CHECK_FALSE(fill(5000, 1900, above));
  }
}

TEST_CASE("a background's slope goes on over rises by less than a quarter, down to a twentieth of its peak") {
  const auto edge = [](std::uint64_t rise, std::uint64_t last) {
    std::vector<std::uint64_t> counts{1000, 600, 100, rise, 70, 60, last};
    counts.resize(60, 40);  // too little for noise about an offset
    const Foreground f = find_foreground(data_of(statistics_of(values(counts))));
    CHECK(f.background);
    CHECK(f.upward);
    return f.edge;
  };
  CHECK(edge(120, 40) == 6);
  CHECK(edge(130, 40) == 3);
  CHECK(edge(120, 52) == 7);
}

TEST_CASE("a background is a peak of at least a tenth of all voxels") {
  for (const std::uint64_t peak : {90U, 120U}) {
    std::vector<std::uint64_t> counts(20, 45);
    counts[0] = peak;
    CHECK(find_foreground(data_of(statistics_of(values(counts)))).background == (peak > 100));
  }
}

TEST_CASE("a plateau has ten times as many voxels as any value about it") {
  for (const std::uint64_t high : {950U, 1050U}) {
    std::vector<std::uint64_t> counts(20, 100);
    counts[10] = high;
    Bins bins = values(counts);
    const auto plateau = flatten_plateaus(bins, count_of(bins));
    CHECK(plateau.has_value() == (high > 1000));
    CHECK(bins[10].count == (high > 1000 ? 100 : high));
    if (plateau) CHECK(plateau->value == 10);
  }
}
