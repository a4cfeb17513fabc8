#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

#include "classify/find_visible.hpp"
#include "classify/phong.hpp"
#include "classify/two_points.hpp"
#include "classify/type_of.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

/// A function with transparent stretches at both ends and in the middle, a ramp, a jump and full opacity.
TransferFunction bumpy(double low, double high) {
  TransferFunction tf = two_points(low, 0, high, 0);
  const auto at = [=](double share) { return low + (high - low) * share; };
  tf.opacities = {{at(0.1), 0},    {at(0.3), 0.6}, {at(0.4), 0}, {at(0.6), 0},
                  {at(0.6), 1e-7}, {at(0.8), 1},   {at(0.9), 0}};
  return tf;
}

struct Row {
  std::vector<std::uint32_t> where;
  std::vector<ClassifiedSample> samples;
};

/// The visible voxels' columns, one by one; blocks ascend.
Row to_row(const VisibleRow& visible) {
  Row row;
  std::uint32_t next = 0;
  for (const VisibleBlock& block : visible.blocks) {
    REQUIRE(block.mask != 0);
    REQUIRE(block.sample == row.where.size());
    REQUIRE((block.first % 64 == 0 && block.first >= next));
    next = block.first + 64;
    for (std::uint32_t k = 0; k < 64; ++k)
      if (block.mask >> k & 1) row.where.push_back(block.first + k);
  }
  REQUIRE(visible.visible == row.where.size());
  REQUIRE(visible.samples.size() >= visible.visible);
  row.samples.assign(visible.samples.begin(), visible.samples.begin() + visible.visible);
  return row;
}

template <class T>
Row classify(const Classifier& classifier, const std::vector<T>& values) {
  const auto* row = reinterpret_cast<const std::byte*>(values.data());
  VisibleRow visible = find_visible(classifier, row, int(values.size()));
  make_samples(classifier, {row, nullptr, int(values.size())}, nullptr, visible);
  return to_row(visible);
}

/// Every value by the transfer function itself and the correction in long double.
template <class T>
void require_row(const TransferFunction& tf, double length, const std::vector<T>& values) {
  const Row row = classify(Classifier(tf, type_of<T>(), length), values);
  std::size_t k = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto expected = tf.evaluate(double(values[i]));
    const long double alpha = expected.opacity;
    const double opacity = double(-std::expm1(static_cast<long double>(length) * std::log1p(-alpha)));
    if (!(float(opacity) > 0)) continue;
    INFO("value " << +values[i] << " at " << i);
    REQUIRE(k < row.where.size());
    REQUIRE(row.where[k] == i);
    REQUIRE(row.samples[k].opacity == Approx(opacity).epsilon(1e-6).margin(0));
    REQUIRE(row.samples[k].r == float(expected.colour.x));
    REQUIRE(row.samples[k].g == float(expected.colour.y));
    REQUIRE(row.samples[k].b == float(expected.colour.z));
    ++k;
  }
  REQUIRE(k == row.where.size());
}

template <class T>
std::vector<T> spread(int count) {
  std::mt19937_64 random(9);
  std::vector<T> values{std::numeric_limits<T>::lowest(), std::numeric_limits<T>::max(), T{0}, T{1}};
  if constexpr (std::is_floating_point_v<T>) {
    std::uniform_real_distribution<T> number(T(-1000), T(1000));
    for (const double v : {nan_value, -nan_value, infinity, -infinity, 1e-320, -1e-320})
      values.push_back(T(v));
    while (int(values.size()) < count) values.push_back(number(random));
  } else {
    std::uniform_int_distribution<std::int64_t> number(std::numeric_limits<T>::min(),
                                                       std::numeric_limits<T>::max());
    while (int(values.size()) < count) values.push_back(T(number(random)));
  }
  return values;
}

}  // namespace

TEMPLATE_TEST_CASE("rows of every type are classified as the transfer function says", "", std::int8_t,
                   std::uint8_t, std::int16_t, std::uint16_t, std::int32_t, std::uint32_t, float, double) {
  using T = TestType;
  const double low = std::is_floating_point_v<T> ? -1000.0 : double(std::numeric_limits<T>::min());
  const double high = std::is_floating_point_v<T> ? 1000.0 : double(std::numeric_limits<T>::max());
  for (const double length : {1.0, 1.7320508, 0.25})
    for (const int count : {4, 11, 4097}) require_row(bumpy(low, high), length, spread<T>(count));
  require_row(two_points(low, 0.3, high, 0.9), 1.3, spread<T>(500));  // visible everywhere
}

TEST_CASE("all values of the 16-bit types") {
  std::vector<std::int16_t> i16(65536);
  std::vector<std::uint16_t> u16(65536);
  std::iota(i16.begin(), i16.end(), std::int16_t(-32768));
  std::iota(u16.begin(), u16.end(), std::uint16_t(0));
  require_row(bumpy(-32768, 20000), 1.2, i16);
  require_row(bumpy(500, 65535), 1.2, u16);
}

TEST_CASE(
    "values beyond a function's first and last points are as these, also where it begins or ends with a "
    "jump") {
  std::vector<std::int16_t> values;
  for (int v = -400; v < 400; ++v) values.push_back(std::int16_t(v));
  values.push_back(-32768);
  values.push_back(32767);
  TransferFunction jumps = two_points(-50.5, 0, 120, 0);
  jumps.opacities = {{-100, 0.2}, {-100, 0.6}, {0, 0.3}, {99.5, 0.5}, {99.5, 0.1}};
  jumps.colours.insert(jumps.colours.begin(), {-50.5, {0, 1, 0}});
  require_row(jumps, 1.4, values);
  jumps.opacities = {{-100, 0}, {-100, 0.6}, {0, 0.3}, {100, 0.5}, {100, 0}};
  require_row(jumps, 1.4, values);
  // All points beyond the type's values, on either side.
  for (const double far : {-1e6, 1e6})
    for (const double opacity : {0.0, 0.4})
      require_row(two_points(far, opacity, far + 10, 0.4 - opacity), 1.4, values);
}

TEST_CASE("the extreme values of a type are met exactly") {
  REQUIRE(classify<std::int16_t>({two_points(-32768, 0.5, -32767, 0), ScalarType::int16, 1},
                                 {-32767, -32768, 32767})
              .where == std::vector<std::uint32_t>{1});
  REQUIRE(classify<std::uint32_t>({two_points(4294967294.0, 0, 4294967295.0, 0.5), ScalarType::uint32, 1},
                                  {4294967294U, 4294967295U, 0})
              .where == std::vector<std::uint32_t>{1});
  REQUIRE(classify<std::int32_t>({two_points(-2147483648.0, 0.5, -2147483647.0, 0), ScalarType::int32, 1},
                                 {-2147483647, std::numeric_limits<std::int32_t>::min()})
              .where == std::vector<std::uint32_t>{1});
  // Neighbouring doubles.
  const double one = 1.0, next = std::nextafter(1.0, 2.0);
  REQUIRE(classify<double>({two_points(one, 0, next, 1), ScalarType::float64, 1}, {one, next}).where ==
          std::vector<std::uint32_t>{1});
}

TEST_CASE("not-a-number is transparent, infinities take the end points' opacity") {
  for (const double length : {1.0, 2.0}) {
    const Classifier both({two_points(0, 0.25, 1, 0.5)}, ScalarType::float32, length);
    const auto row = classify<float>(both, {float(nan_value), float(infinity), -float(infinity)});
    REQUIRE(row.where == std::vector<std::uint32_t>{1, 2});
    REQUIRE(row.samples[0].opacity == Approx(length == 1.0 ? 0.5 : 0.75));
    REQUIRE(row.samples[1].opacity == Approx(length == 1.0 ? 0.25 : 0.4375));
    REQUIRE(row.samples[0].r == 1.0F);
  }
  const Classifier clear_ends(bumpy(0, 1), ScalarType::float64, 1);
  REQUIRE(classify<double>(clear_ends, {infinity, -infinity, nan_value}).where.empty());
}

TEST_CASE("the opacity correction is exact for 1, and keeps the digits of tiny opacities") {
  const auto corrected = [](double opacity, double length) {
    const auto row =
        classify<float>({two_points(0, opacity, 1, opacity), ScalarType::float32, length}, {0.5F});
    return row.samples.empty() ? 0.0F : row.samples[0].opacity;
  };
  for (const double length : {1e-9, 0.5, 1.0, 1.7, 1e9, infinity}) REQUIRE(corrected(1.0, length) == 1.0F);
  for (const double opacity : {1e-7, 1e-12, 1e-30})
    for (const double length : {0.5, 1.25, 1.7320508})
      REQUIRE(corrected(opacity, length) == Approx(opacity * length).epsilon(1.5e-7).margin(0));
  REQUIRE(corrected(0.3, 1.0) == 0.3F);
  REQUIRE(corrected(0.5, 2.0) == 0.75F);
  REQUIRE(corrected(0.5, 1e300) == 1.0F);
  REQUIRE(corrected(0.5, infinity) == 1.0F);
  REQUIRE(corrected(1.0 - 1e-16, 0.5) == 1.0F);
  REQUIRE(corrected(0.9999, 1.5) == Approx(1 - std::pow(1e-4, 1.5)).epsilon(1e-6));
  REQUIRE(corrected(1e-60, 1.0) == 0.0F);  // below float32: transparent, not a sample of opacity zero
}

TEST_CASE("rows may be empty, of one voxel, and at any address") {
  const Classifier classifier(two_points(0, 0, 1000, 1), ScalarType::int16, 1.1);
  REQUIRE(find_visible(classifier, nullptr, 0).visible == 0);
  REQUIRE(classify<std::int16_t>(classifier, {7}).where.size() == 1);
  std::byte bytes[9]{};
  const std::int16_t values[4] = {100, -5, 300, 2000};
  std::memcpy(bytes + 1, values, sizeof(values));
  VisibleRow row = find_visible(classifier, bytes + 1, 4);
  make_samples(classifier, {bytes + 1, nullptr, 4}, nullptr, row);
  REQUIRE(to_row(row).where == std::vector<std::uint32_t>{0, 2, 3});
  REQUIRE(row.samples[2].opacity == 1.0F);
}

TEMPLATE_TEST_CASE("a row's stretches one after the other give what the whole row gives", "", std::uint8_t,
                   std::int16_t, float) {
  // Transparent at the ends and in the middle; visible throughout between the ends; nowhere transparent. Also
  // runs longer than a machine word.
  const double high = std::is_same_v<TestType, float> ? 1000.0 : double(std::numeric_limits<TestType>::max());
  const auto values = spread<TestType>(900);
  std::vector<TestType> smooth(900);
  for (std::size_t i = 0; i < smooth.size(); ++i)
    smooth[i] = TestType(high * (0.5 + 0.5 * std::sin(double(i) / 60)));
  for (const auto& tf :
       {bumpy(0, high), two_points(high / 4, 0, high / 2, 1), two_points(-1e6, 0.5, 1e6, 0.5)}) {
    const Classifier classifier(tf, type_of<TestType>(), 1.2);
    for (const auto& row : {values, smooth}) {
      const Row whole = classify(classifier, row);
      std::vector<std::uint64_t> masks(masks_of(900), 0);
      for (const auto& [first, end] :
           {std::pair(0, 1), {1, 64}, {64, 64}, {64, 130}, {130, 331}, {331, 332}, {332, 900}})
        classifier.find_row(reinterpret_cast<const std::byte*>(row.data()), first, end, masks.data());
      VisibleRow visible;
      visible.blocks.push_back({0, 0, 511});  // take() drops it
      visible.visible = 9;
      visible.take(masks, 0, 900);
      make_samples(classifier, {reinterpret_cast<const std::byte*>(row.data()), nullptr, 900}, nullptr,
                   visible);
      const Row stretches = to_row(visible);
      REQUIRE(stretches.where == whole.where);
      for (std::size_t k = 0; k < whole.samples.size(); ++k)
        REQUIRE(std::memcmp(&stretches.samples[k], &whole.samples[k], sizeof(ClassifiedSample)) == 0);
    }
  }
}

TEST_CASE("of a row's masks any stretch of columns can be taken") {
  std::mt19937_64 random(3);
  const std::vector<std::uint64_t> masks{random(), 0, random(), ~std::uint64_t{0}};
  for (std::uint32_t first = 0; first < 256; first += 7)
    for (std::uint32_t end = 0; end <= 256; end += 1 + first % 3) {
      VisibleRow row;
      row.take(masks, first, end);
      std::vector<std::uint32_t> expected, taken;
      for (std::uint32_t column = first; column < end; ++column)
        if (masks[column / 64] >> column % 64 & 1) expected.push_back(column);
      std::uint32_t before = 0;
      for (const VisibleBlock& block : row.blocks) {
        REQUIRE((block.mask != 0 && block.sample == before));
        for (std::uint32_t k = 0; k < 64; ++k)
          if (block.mask >> k & 1) taken.push_back(block.first + k);
        before = std::uint32_t(taken.size());
      }
      REQUIRE(taken == expected);
      REQUIRE(row.visible == expected.size());
    }
}

TEST_CASE("a function that is clear everywhere classifies nothing") {
  for (const auto type : {ScalarType::uint8, ScalarType::float64}) {
    const Classifier classifier(two_points(0, 0, 1, 0), type, 1);
    std::vector<double> values{-infinity, 0, 0.5, 1, infinity, nan_value};
    const VisibleRow row = find_visible(classifier, reinterpret_cast<const std::byte*>(values.data()), 6);
    REQUIRE(row.visible == 0);
    REQUIRE(row.blocks.empty());
  }
}
