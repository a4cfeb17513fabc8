#include <cmath>
#include <limits>

#include "ringsplat/volume/statistics.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {
constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
constexpr float infinite = std::numeric_limits<float>::infinity();

template <class T>
std::span<const std::byte> bytes(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}
}  // namespace

TEST_CASE("a range takes finite values only and counts the others", "[statistics]") {
  ValueRange range;
  CHECK(range.empty());
  CHECK(range.low > range.high);
  range.add(ScalarType::float32,
            bytes(std::vector<float>{not_a_number, 3, -infinite, -2, infinite, 7.5F, -not_a_number}));
  CHECK(range.low == -2);
  CHECK(range.high == 7.5);
  CHECK(range.finite == 3);
  CHECK(range.not_finite == 4);
}

TEST_CASE("a range of NaN only is empty and merging it changes nothing but the count", "[statistics]") {
  ValueRange none, some;
  none.add(ScalarType::float64, bytes(std::vector<double>{double(not_a_number), double(infinite)}));
  CHECK(none.empty());
  some.add(ScalarType::int16, bytes(std::vector<std::int16_t>{-5, 900}));
  some.merge(none);
  CHECK(some.low == -5);
  CHECK(some.high == 900);
  CHECK(some.finite == 2);
  CHECK(some.not_finite == 2);
}

TEST_CASE("ranges reach the ends of every type", "[statistics]") {
  for (const ScalarType type :
       {ScalarType::int8, ScalarType::uint8, ScalarType::int16, ScalarType::uint16, ScalarType::int32,
        ScalarType::uint32, ScalarType::float32, ScalarType::float64})
    visit_type(type, [type](auto zero) {
      using Limits = std::numeric_limits<decltype(zero)>;
      ValueRange range;
      range.add(type, bytes(std::vector{decltype(zero)(1), Limits::max(), Limits::lowest()}));
      CHECK(range.low == double(Limits::lowest()));
      CHECK(range.high == double(Limits::max()));
      CHECK(range.finite == 3);
    });
}

TEST_CASE("a histogram's bins are half open but for the last", "[statistics]") {
  Histogram histogram(0, 10, 5);
  histogram.add(ScalarType::float32, bytes(std::vector<float>{0, 1.9F, 2, 9.9F, 10, -0.1F, 10.1F,
                                                              not_a_number, infinite, -infinite}));
  CHECK(histogram.counts == std::vector<std::uint64_t>{2, 1, 0, 0, 2});
  CHECK(histogram.total() == 5);
}

TEST_CASE("8-bit values are counted like any other", "[statistics]") {
  std::vector<std::int8_t> narrow;
  std::vector<std::int32_t> wide;
  for (int i = 0; i < 1003; ++i) {
    narrow.push_back(std::int8_t((i * 37) % 256 - 128));
    wide.push_back(narrow.back());
  }
  Histogram a(-100, 90, 17), b(-100, 90, 17);
  a.add(ScalarType::int8, bytes(narrow));
  b.add(ScalarType::int32, bytes(wide));
  CHECK(a.counts == b.counts);
  CHECK(a.total() > 700);
}

TEST_CASE("one single value falls into the first bin", "[statistics]") {
  Histogram histogram(4, 4, 8);
  histogram.add(ScalarType::uint16, bytes(std::vector<std::uint16_t>{4, 4, 5}));
  CHECK(histogram.counts[0] == 2);
  CHECK(histogram.total() == 2);
}
