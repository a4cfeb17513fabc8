#include <random>

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
#include "volume/cell_ranges.hpp"

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

TEST_CASE("all blocks that pixels may show are among those that are found for them, and few others") {
  std::mt19937 random(3);
  const auto within = [&random](double low, double high) {
    return low + (high - low) * (double(random()) / double(std::mt19937::max()));
  };
  FrameSpec spec{.how = Sheets{}};
  spec.shown.width = 160;
  spec.shown.height = 120;
  spec.shown.transfer_function = ramp(20, 255, 0.9);
  int found = 0, all = 0;
  for (int view = 0; view < 300; ++view) {
    spec.shown.camera = {.azimuth = within(0, 360),
                         .elevation = within(-90, 90),
                         .roll = within(0, 360),
                         .zoom = within(0.3, 8),
                         .fov = view % 2 == 0 ? 0 : within(5, 120),
                         .distance = view % 2 == 0 ? 0 : within(1.05, 3)};
    const auto frame = make_sheet_frame(spec, make_grid({90, 70, 40}), 1, 1);
    const FrameGeometry& g = frame->geometry;
    const BlockWindows windows(g, frame->reach(), frame->reach(), frame->reach());
    const int columns = CellRanges::blocks_along(g.grid.slice_width(g.traversal.axis)),
              rows = CellRanges::blocks_along(g.grid.slice_height(g.traversal.axis)),
              slice = int(within(0, g.slices)), x = int(within(0, 160)), y = int(within(0, 120));
    const PixelWindow pixels{x, y, x + int(within(0, 40)), y + int(within(0, 40))};
    const PixelRect blocks = windows.blocks_in(pixels, slice, columns, rows);
    CAPTURE(view, slice, x, y);
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) {
        const PixelWindow seen = windows.of(column, row, slice);
        if (seen.x1 - seen.x0 > 1'000'000)
          continue;  // it reaches beside the eye, where rays meet other blocks
        if (seen.x1 < pixels.x0 || seen.x0 > pixels.x1 || seen.y1 < pixels.y0 || seen.y0 > pixels.y1)
          continue;
        REQUIRE((column >= blocks.x0 && column < blocks.x1 && row >= blocks.y0 && row < blocks.y1));
      }
    found += blocks.width() * blocks.height();
    all += columns * rows;
  }
  CAPTURE(all, found);
  CHECK(found < all / 2);
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
