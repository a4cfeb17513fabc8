#include "base/byte_stream.hpp"
#include "net/message.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "sheet_engine/slice_blocks.hpp"
#include "simulate/meter.hpp"
#include "support/catch.hpp"
#include "support/dealt.hpp"
#include "support/seen_from_above.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

struct Sum {
  double payloads = 0, items = 0, bytes = 0, told = 0, samples = 0;
};

Sum sum_of(Encoder& encoder) {
  Sum sum;
  for (const int step : {20, 50, 90, 120}) {
    encoder.begin(step);
    while (!encoder.work()) {
    }
    for (const EncodedPart& part : encoder.finish().parts) {
      if (part.payload.empty()) continue;
      MeasuredPayload measured;
      std::size_t at = sizeof(Header);
      REQUIRE(take(part.payload, at, measured));
      ++sum.payloads;
      sum.items += double(part.items);
      sum.bytes += double(measured.bytes);
      sum.told += double(measured.work.blocks);
      sum.samples += double(measured.work.samples);
    }
  }
  return sum;
}

}  // namespace

TEST_CASE("voxels that stand for others are counted as the blocks of these") {
  // A volume, and one of every fourth of its voxels along x and y.
  const Grid fine = make_grid({192, 192, 128}),
             coarse = make_grid({48, 48, 128}, ScalarType::uint8, {4, 4, 1});
  Sum sums[2];
  for (const bool weighed : {false, true}) {
    const auto frame = seen_from_above(weighed ? coarse : fine, ramp(110, 255, 0.3));
    const auto stores = dealt_for_sheets(*synth_source("ball", frame->geometry.grid));
    SliceBlocks blocks;
    const auto encoder =
        weighed ? make_weighed_encoder(frame, renderers, stores.at(0), 16)
                : make_measuring_encoder(make_sheet_encoder(frame, renderers, stores.at(0), blocks, false),
                                         make_sheet_meter(frame));
    sums[int(weighed)] = sum_of(*encoder);
  }
  const auto& [real, weighed] = sums;
  CHECK(weighed.payloads == Approx(real.payloads).epsilon(0.1));
  CHECK(weighed.items == Approx(real.items).epsilon(0.1));
  CHECK(weighed.bytes == Approx(real.bytes).epsilon(0.1));
  CHECK(weighed.told == Approx(real.told).epsilon(0.15));
  CHECK(weighed.samples == Approx(real.samples).epsilon(0.1));
}
