#include <numeric>

#include "frame/work_estimate.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

std::vector<RegionWork> all_of(const Regions& regions) {
  std::vector<RegionWork> work;
  for (int region = 0; region < regions.count(); ++region) work.push_back({region, 1.0});
  return work;
}

std::vector<double> sums(const std::vector<RegionWork>& work, const std::vector<int>& owner, int owners) {
  std::vector<double> sum(std::size_t(owners), 0.0);
  for (const RegionWork& one : work) sum[std::size_t(owner[std::size_t(one.region)])] += one.seconds;
  return sum;
}

}  // namespace

TEST_CASE("a square is cut across first, and its halves along") {
  const Regions regions(64, 64, 16);
  CHECK(bisect(regions, all_of(regions), std::vector<double>(4, 1.0)) ==
        std::vector<int>{0, 0, 1, 1, 0, 0, 1, 1, 2, 2, 3, 3, 2, 2, 3, 3});
}

TEST_CASE("a wide strip is cut along") {
  const Regions regions(96, 16, 16);
  CHECK(bisect(regions, all_of(regions), std::vector<double>(3, 1.0)) == std::vector<int>{0, 0, 1, 1, 2, 2});
}

TEST_CASE("each gets as much as it has room for, and a cut may have a step") {
  const Regions regions(160, 160, 16);
  const auto work = all_of(regions);
  const auto got = sums(work, bisect(regions, work, std::vector<double>{3, 0, 1, 1}), 4);
  CHECK(got == std::vector<double>{60, 0, 20, 20});
  const auto thirds = sums(work, bisect(regions, work, std::vector<double>(3, 1.0)), 3);
  CHECK(thirds == std::vector<double>{33, 33, 34});
}

TEST_CASE("without any room all get alike, and what is not given is nobody's") {
  const Regions regions(64, 16, 16);
  CHECK(bisect(regions, {{1, 1.0}, {2, 1.0}}, std::vector<double>{0, 0}) ==
        std::vector<int>{nobody, 0, 1, nobody});
  CHECK(bisect(regions, {}, std::vector<double>{1, 1}) == std::vector<int>(4, nobody));
}
