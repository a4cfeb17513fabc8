// The statistics of a volume's values, over processes.
#include <cstring>
#include <limits>
#include <random>

#include "scene/scene.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/scenes.hpp"
#include "support/thread_collectives.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

struct Noted final : VolumeSource {
  Noted(const Grid& grid, std::span<const std::byte> voxels, VolumeNotes notes)
      : source(memory_source(grid, voxels)), said(std::move(notes)) {}
  const Grid& grid() const override { return source->grid(); }
  bool concurrent() const override { return source->concurrent(); }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    source->read_slices(first, count, out);
  }
  VolumeNotes notes() const override { return said; }
  std::unique_ptr<VolumeSource> source;
  VolumeNotes said;
};

/// The statistics that so many processes with a GP each come to.
ValueStatistics statistics_of(const Grid& grid, std::span<const std::byte> voxels, const VolumeNotes& notes,
                              int processes) {
  std::vector<ValueStatistics> found(static_cast<std::size_t>(processes));
  std::vector<int> process_of_gp;
  for (int p = 0; p < processes; ++p) process_of_gp.push_back(p);
  const auto thrown = run_as_processes(processes, [&](ThreadCollectives& collectives) {
    OpenedVolume volume =
        open_everywhere(collectives, [&] { return std::make_unique<Noted>(grid, voxels, notes); });
    const auto stores = deal_slices(volume, {}, {processes, process_of_gp, collectives});
    found[std::size_t(collectives.process())] = share_values(stores, grid, volume.notes, collectives);
  });
  REQUIRE(thrown == std::vector<std::string>(std::size_t(processes)));
  for (const auto& one : found) {
    CHECK(one.histogram.counts == found[0].histogram.counts);
    CHECK(one.labels == found[0].labels);
  }
  return found[0];
}

void require_same(const ValueStatistics& a, const ValueStatistics& b) {
  CHECK(a.range.low == b.range.low);
  CHECK(a.range.high == b.range.high);
  CHECK(a.range.finite == b.range.finite);
  CHECK(a.range.not_finite == b.range.not_finite);
  CHECK(a.fill_voxels == b.fill_voxels);
  CHECK(a.histogram.low == b.histogram.low);
  CHECK(a.histogram.high == b.histogram.high);
  CHECK(a.histogram.counts == b.histogram.counts);
  CHECK(a.histogram.below == b.histogram.below);
  CHECK(a.histogram.above == b.histogram.above);
  CHECK(a.labels == b.labels);
  REQUIRE(a.bins.size() == b.bins.size());
  for (std::size_t k = 0; k < a.bins.size(); ++k) {
    CHECK(a.bins[k].low == b.bins[k].low);
    CHECK(a.bins[k].count == b.bins[k].count);
  }
  REQUIRE(a.neighbours.has_value() == b.neighbours.has_value());
  if (a.neighbours) {
    CHECK(a.neighbours->equal == b.neighbours->equal);
    CHECK(a.neighbours->alone == b.neighbours->alone);
  }
}

template <class T>
std::vector<T> odd_values(std::size_t count) {
  std::mt19937 random(3);
  std::vector<T> values(count);
  for (std::size_t k = 0; k < count; ++k) {
    values[k] = static_cast<T>(random() % 250 + 3);
    if (k % 7 == 0) values[k] = static_cast<T>(-99);
  }
  return values;
}

}  // namespace

TEST_CASE("a volume's statistics are the same on 1, 2, 3 and 5 processes") {
  Grid grid = make_grid({12, 10, 11});
  VolumeNotes notes;
  notes.fill = -99;
  const auto check_all = [&](std::span<const std::byte> voxels) {
    const auto alone = statistics_of(grid, voxels, notes, 1);
    CHECK(alone.fill_voxels == (1320 + 6) / 7);
    CHECK(alone.range.low >= 3);
    for (const int processes : {2, 3, 5}) require_same(statistics_of(grid, voxels, notes, processes), alone);
  };
  grid.type = ScalarType::float32;
  auto floats = odd_values<float>(1320);
  floats[1] = 1e30F;
  floats[2] = std::numeric_limits<float>::quiet_NaN();
  check_all(std::as_bytes(std::span(floats)));
  grid.type = ScalarType::int16;
  const auto shorts = odd_values<std::int16_t>(1320);
  check_all(std::as_bytes(std::span(shorts)));
  grid.type = ScalarType::int32;
  const auto ints = odd_values<std::int32_t>(1320);
  check_all(std::as_bytes(std::span(ints)));
}

TEST_CASE("values that are not finite are counted on processes that have no others") {
  Grid grid = make_grid({3, 3, 4});
  grid.type = ScalarType::float32;
  std::vector<float> voxels(36, std::numeric_limits<float>::quiet_NaN());
  voxels[20] = std::numeric_limits<float>::infinity();
  for (const int finite : {0, 1}) {
    if (finite > 0) voxels[35] = 7;
    for (const int processes : {1, 2, 4}) {
      const auto all = statistics_of(grid, std::as_bytes(std::span(voxels)), {}, processes);
      CHECK(all.range.finite == std::uint64_t(finite));
      CHECK(all.range.not_finite == std::uint64_t(36 - finite));
    }
  }
}

TEST_CASE("labels are counted the same on any number of processes") {
  Grid grid = make_grid({12, 10, 11});
  grid.type = ScalarType::int32;
  std::vector<std::int32_t> labels(1320);
  for (std::size_t k = 0; k < labels.size(); ++k) {
    static constexpr std::int32_t known[] = {0, 2, 41, 2035, 100000};
    labels[k] = known[(k / 4) * 7919 % 5];
  }
  const auto voxels = std::as_bytes(std::span(labels));
  const auto alone = statistics_of(grid, voxels, {}, 1);
  CHECK(alone.labels == std::vector<double>{0, 2, 41, 2035, 100000});
  REQUIRE(alone.neighbours);
  for (const int processes : {2, 3, 5}) require_same(statistics_of(grid, voxels, {}, processes), alone);
}
