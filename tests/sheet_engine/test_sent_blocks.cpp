#include "net/message.hpp"
#include "sheet_engine/block_windows.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "sheet_engine/sheet_payload.hpp"
#include "sheet_engine/slice_blocks.hpp"
#include "support/catch.hpp"
#include "support/dealt.hpp"
#include "support/message_of.hpp"
#include "support/seen_from_above.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

EncodedStep encoded(Encoder& encoder, int step) {
  encoder.begin(step);
  while (!encoder.work()) {
  }
  return encoder.finish();
}

}  // namespace

TEST_CASE("a Renderer is told only of blocks that it can see, whatever the function hides in between") {
  TransferFunction shell;
  shell.colours = {{0, {1, 1, 1}}, {255, {1, 1, 1}}};
  shell.opacities = {{0, 0}, {40, 0}, {60, 1}, {80, 0}, {255, 0}};
  const auto frame = seen_from_above(make_grid({96, 96, 12}), shell);
  const auto stores = dealt_for_sheets(*synth_source("ball", frame->geometry.grid));
  SliceBlocks blocks;
  const auto encoder = make_sheet_encoder(frame, renderers, stores.at(0), blocks, true);
  const BlockWindows windows(frame->geometry, frame->reach(), frame->reach(), frame->reach());
  const Regions& regions = frame->geometry.regions;
  const auto sees = [&](int renderer, int column, int row) {
    const PixelWindow window = windows.of(column, row, 6);
    const PixelRect touched = regions.touched(window);
    for (int y = touched.y0; y < touched.y1; ++y)
      for (int x = touched.x0; x < touched.x1; ++x)
        if (frame->plan.tiles[std::size_t(y * regions.columns() + x)].renderer == renderer) return true;
    return false;
  };
  const auto parts = encoded(*encoder, 6).parts;
  int told_hidden = 0;
  for (int r = 0; r < renderers; ++r) {
    const auto body = std::span(parts.at(std::size_t(r)).payload).subspan(sizeof(Header));
    const SheetPayload payload = read_sheet_payload(body, 96, 96, ScalarType::uint8);
    payload.for_each_block([&](int column, int row, std::uint8_t byte) {
      if (byte == payload.header.elsewhere) return;
      CHECK(sees(r, column, row));
      told_hidden += byte < block_present ? 1 : 0;
    });
  }
  CHECK(told_hidden > 0);
}

TEST_CASE("a GP refuses sheets of slices whose cells' ranges were not loaded, unless it has none") {
  const auto source = synth_source("ball", make_grid({24, 24, 12}));
  const auto frame = seen_from_above(source->grid(), ramp(20, 255, 0.9));
  const auto encode = [&](const SliceStore& store) {
    SliceBlocks blocks;
    return message_of<RunError>([&] { make_sheet_encoder(frame, renderers, store, blocks, true); });
  };
  CHECK(says(encode(dealt(*source, 1).at(0)), "ranges of the cells between slices were not loaded"));
  CHECK(encode(dealt_for_sheets(*source).at(0)).empty());
  CHECK(encode(dealt(*source, 13).at(12)).empty());
}
