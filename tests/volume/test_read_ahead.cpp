// Reading the next volume of a series while another is drawn.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "volume/read_ahead.hpp"

using namespace ringsplat;
using namespace std::chrono_literals;

namespace {

constexpr int depth = 12;
constexpr std::size_t slice_bytes = 6;

/// Slice z holds z; counts reads, and those that came while another was under way.
struct Watch {
  std::atomic<int> reads = 0, inside = 0, overlaps = 0;
  int fails_at = -1;
};

class CountingSource final : public VolumeSource {
 public:
  explicit CountingSource(Watch& watch) : watch_(watch) {
    grid_.dims = {3, 2, depth};
    grid_.type = ScalarType::uint8;
  }
  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return false; }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    if (watch_.inside++ > 0) ++watch_.overlaps;
    ++watch_.reads;
    std::this_thread::sleep_for(1ms);
    for (std::size_t k = 0; k < std::size_t(count) * slice_bytes; ++k)
      out[k] = std::byte(first + int(k / slice_bytes));
    --watch_.inside;
    if (first <= watch_.fails_at && watch_.fails_at < first + count) throw InputError("slice cannot be read");
  }

 private:
  Watch& watch_;
  Grid grid_;
};

std::vector<SliceRun> one_by_one() {
  std::vector<SliceRun> runs;
  for (int z = 0; z < depth; ++z) runs.push_back({z, 1});
  return runs;
}

void check_read(VolumeSource& source, int first, int count) {
  std::vector<std::byte> out(std::size_t(count) * slice_bytes);
  source.read_slices(first, count, out);
  for (std::size_t k = 0; k < out.size(); ++k) CHECK(out[k] == std::byte(first + int(k / slice_bytes)));
}

}  // namespace

TEST_CASE("what is noted of a reading has each slice once, in order") {
  Watch watch;
  std::vector<SliceRun> runs{{7, 7}};
  NotingSource source(std::make_unique<CountingSource>(watch), runs);
  for (const SliceRun& run : {SliceRun{2, 2}, {3, 1}, {0, 2}, {3, 3}, {2, 2}})
    check_read(source, run.first, run.count);
  CHECK(runs == std::vector<SliceRun>{{2, 2}, {0, 2}, {3, 3}});
}

TEST_CASE("slices that were read ahead are not read again, however often they are asked for", "[threads]") {
  Watch watch;
  ReadAheadSource source(std::make_unique<CountingSource>(watch), one_by_one(), depth * slice_bytes);
  for (int round = 0; round < 3; ++round)
    for (int z = 0; z + 1 < depth; ++z) check_read(source, z, 2);
  CHECK(watch.reads == depth);
}

TEST_CASE("reading ahead begins before anything is asked for", "[threads]") {
  Watch watch;
  ReadAheadSource source(std::make_unique<CountingSource>(watch), one_by_one(), depth * slice_bytes);
  for (int k = 0; k < 10000 && watch.reads < depth; ++k) std::this_thread::sleep_for(1ms);
  CHECK(watch.reads == depth);
}

TEST_CASE("reading ahead keeps within its memory, and the rest is read when it is asked for", "[threads]") {
  Watch watch;
  ReadAheadSource source(std::make_unique<CountingSource>(watch), one_by_one(), 4 * slice_bytes);
  for (int z = 0; z < depth; ++z) {
    check_read(source, z, 1);
    CHECK(watch.reads <= std::max(z + 1, 4));
  }
  CHECK(watch.reads == depth);
  CHECK(watch.overlaps == 0);
}

TEST_CASE("slices asked for in another order than was expected are right, by one thread at a time",
          "[threads]") {
  for (const std::size_t held : {std::size_t{0}, 2 * slice_bytes, 100 * slice_bytes}) {
    INFO(held << " bytes");
    Watch watch;
    ReadAheadSource source(std::make_unique<CountingSource>(watch), {{0, 3}, {6, 3}}, held);
    for (const int first : {9, 4, 0, 10, 6, 2, 7, 1}) check_read(source, first, 2);
    CHECK(watch.overlaps == 0);
  }
}

TEST_CASE("an error of reading ahead comes where its slices are asked for", "[threads]") {
  Watch watch;
  watch.fails_at = 5;
  ReadAheadSource source(std::make_unique<CountingSource>(watch), one_by_one(), depth * slice_bytes);
  for (int z = 0; z < 5; ++z) check_read(source, z, 1);
  std::vector<std::byte> out(slice_bytes);
  CHECK_THROWS_AS(source.read_slices(5, 1, out), InputError);
}

TEST_CASE("reading ahead can be given up at any time", "[threads]") {
  Watch watch;
  for (int k = 0; k < 20; ++k) {
    const ReadAheadSource source(std::make_unique<CountingSource>(watch), one_by_one(), 3 * slice_bytes);
    std::this_thread::sleep_for(std::chrono::microseconds(300 * k));
  }
  CHECK(watch.overlaps == 0);
}
