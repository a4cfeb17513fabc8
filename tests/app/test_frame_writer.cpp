#include "app/frame_output.hpp"

#include <atomic>
#include <chrono>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app;

namespace {

FinishedFrame numbered(std::int64_t frame) {
  FinishedFrame finished;
  finished.result.spec.frame = frame;
  return finished;
}

}  // namespace

TEST_CASE("frames are written in order by another thread", "[threads]") {
  std::vector<std::int64_t> written;
  bool other_thread = true;
  FrameWriter writer([&, caller = std::this_thread::get_id()](FinishedFrame&& frame) {
    other_thread = other_thread && std::this_thread::get_id() != caller;
    written.push_back(frame.result.spec.frame);
  });
  for (int k = 0; k < 50; ++k) writer.put(numbered(k));
  writer.finish();
  REQUIRE(written.size() == 50);
  for (int k = 0; k < 50; ++k) CHECK(written[std::size_t(k)] == k);
  CHECK(other_thread);
}

TEST_CASE("no more frames wait than there is room for", "[threads]") {
  std::atomic<bool> may_write = false;
  std::atomic<int> put = 0, written = 0;
  FrameWriter writer([&](FinishedFrame&&) {
    while (!may_write) std::this_thread::yield();
    ++written;
  });
  constexpr int held = int(FrameWriter::room) + 1;
  std::thread renders([&] {
    for (int k = 0; k < held + 5; ++k) {
      writer.put(numbered(k));
      ++put;
    }
  });
  while (put < held) std::this_thread::yield();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  CHECK(put == held);
  CHECK(written == 0);
  may_write = true;
  renders.join();
  writer.finish();
  CHECK(written == held + 5);
}

TEST_CASE("what writing throws comes out, and nothing is written after it", "[threads]") {
  std::atomic<int> written = 0;
  const auto fail_at_2 = [&](FinishedFrame&& frame) {
    if (frame.result.spec.frame == 2) throw RunError("the disk is full");
    ++written;
  };
  SECTION("in the middle") {
    FrameWriter writer(fail_at_2);
    const auto put_many = [&] {
      for (int k = 0; k < 20; ++k) writer.put(numbered(k));
    };
    CHECK_THROWS_WITH(put_many(), Catch::Matchers::Contains("the disk is full"));
    CHECK_THROWS_AS(writer.finish(), RunError);
  }
  SECTION("at the end") {
    FrameWriter writer(fail_at_2);
    for (int k = 0; k < 3; ++k) writer.put(numbered(k));
    CHECK_THROWS_AS(writer.finish(), RunError);
  }
  CHECK(written == 2);
}

TEST_CASE("a run that ends early has its complete frames written", "[threads]") {
  int written = 0;
  {
    FrameWriter writer([&](FinishedFrame&&) { ++written; });
    for (int k = 0; k < 3; ++k) writer.put(numbered(k));
  }
  CHECK(written == 3);
  const FrameWriter unused([&](FinishedFrame&&) { ++written; });
  CHECK(written == 3);
}
