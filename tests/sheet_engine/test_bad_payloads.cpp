#include <array>
#include <cstring>
#include <random>

#include "base/byte_stream.hpp"
#include "base/thread_team.hpp"
#include "net/message.hpp"
#include "ringsplat/base/error.hpp"
#include "sheet_engine/layers.hpp"
#include "sheet_engine/sheet_engine.hpp"
#include "sheet_engine/sheet_payload.hpp"
#include "sheet_engine/slice_blocks.hpp"
#include "support/catch.hpp"
#include "support/dealt.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// A slice of 35 x 20 voxels as it is sent.
Bytes payload_of_a_slice(std::shared_ptr<const SheetFrame> frame) {
  const auto source = synth_source("ball", frame->geometry.grid);
  const auto stores = dealt_for_sheets(*source);
  SliceBlocks blocks;
  const auto encoder = make_sheet_encoder(std::move(frame), 1, stores.at(0), blocks, true);
  encoder->begin(3);
  while (!encoder->work()) {
  }
  Bytes body = encoder->finish().parts.at(0).payload;
  body.erase(body.begin(), body.begin() + sizeof(Header));
  return body;
}

std::shared_ptr<const SheetFrame> frame_of_slices() {
  FrameSpec spec = oblique_view(60, 60, 0);
  spec.shown.camera = {.azimuth = 10, .elevation = 75};
  spec.how = Sheets{};
  auto frame = make_sheet_frame(spec, make_grid({35, 20, 9}), 1, 1);
  REQUIRE(frame->geometry.traversal.axis == Axis::z);
  return frame;
}

bool is_payload(std::span<const std::byte> body, int width = 35, int height = 20,
                ScalarType type = ScalarType::uint8) {
  try {
    static_cast<void>(read_sheet_payload(body, width, height, type));
  } catch (const RunError&) {
    return false;
  }
  return true;
}

}  // namespace

TEST_CASE("a payload of blocks is taken apart, and refused when it is anything else") {
  const Bytes body = payload_of_a_slice(frame_of_slices());
  REQUIRE(is_payload(body));
  const SheetPayload payload = read_sheet_payload(body, 35, 20, ScalarType::uint8);
  CHECK(payload.header.present > 0);
  CHECK(!payload.voxels.empty());
  CHECK(!is_payload(body, 35, 20, ScalarType::int8));
  CHECK(!is_payload(body, 35, 8));
  CHECK(!is_payload(body, 27, 20));
  for (std::size_t bytes = 0; bytes < body.size(); ++bytes)
    REQUIRE(!is_payload(std::span(body).first(bytes)));
  Bytes longer = body;
  longer.push_back(std::byte{});
  CHECK(!is_payload(longer));
  const auto changed = [&](std::size_t at, int value) {
    Bytes other = body;
    other[at] = std::byte(value);
    return is_payload(other);
  };
  CHECK(!changed(offsetof(SheetHeader, present), int(body[offsetof(SheetHeader, present)]) + 1));
  CHECK(!changed(offsetof(SheetHeader, rows), 200));
  CHECK(!changed(offsetof(SheetHeader, elsewhere), 77));
}

TEST_CASE("a Renderer draws or refuses whatever arrives, and never reads beyond it") {
  const auto frame = frame_of_slices();
  const Bytes body = payload_of_a_slice(frame);
  ThreadTeam threads(1);
  std::mt19937 random(7);
  int drawn = 0, refused = 0;
  for (int round = 0; round < 400; ++round) {
    Bytes changed = body;
    const std::size_t places = round % 4 + 1,
                      within = round % 2 == 0 ? changed.size() : sizeof(SheetHeader) + 16;
    for (std::size_t k = 0; k < places; ++k) changed[random() % within] = std::byte(random() % 256);
    const auto painter = make_sheet_painter(0, threads);
    painter->begin_frame(frame);
    try {
      painter->begin({.step = int(random() % 9), .body = changed});
      while (!painter->work()) {
      }
      while (painter->conclude()) {
      }
      ++drawn;
    } catch (const RunError&) {
      ++refused;
    }
  }
  CHECK(drawn > 0);
  CHECK(refused > 0);
}

TEST_CASE("a step that the traversal does not have is refused") {
  const auto frame = frame_of_slices();
  const Bytes body = payload_of_a_slice(frame);
  ThreadTeam threads(1);
  const auto painter = make_sheet_painter(0, threads);
  painter->begin_frame(frame);
  CHECK_THROWS_AS(painter->begin({.step = 9, .body = body}), RunError);
  CHECK_THROWS_AS(painter->begin({.step = -1, .body = body}), RunError);
}

TEST_CASE("layers are composited from the front, and refused when they are anything else") {
  FrameSpec spec = oblique_view(60, 60, 0);
  spec.shown.camera = {.azimuth = 10, .elevation = 75};
  spec.how = Sheets{.layers = 4};
  const auto frame = make_sheet_frame(spec, make_grid({35, 20, 9}), 1, 1);
  REQUIRE(frame->geometry.layers.count == 3);
  const int tiles = frame->geometry.layers.picture.count();
  const bool ascending = frame->geometry.traversal.ascending;
  // Pixels 5 and 6 of tile 1 in the front layer and the last, the last one first.
  Bytes bytes;
  for (const int layer : {ascending ? 2 : 0, ascending ? 0 : 2}) {
    append(bytes, std::int64_t(layer * tiles + 1));
    append(bytes, std::uint64_t{8 + 2 * 8});
    append(bytes, std::array<std::uint32_t, 2>{5, 2});
    constexpr std::uint16_t quarter = 0x3400, half = 0x3800, one = 0x3c00;
    append(bytes, std::array<std::uint16_t, 8>{quarter, half, 0, half, one, 0, 0, one});
  }
  LayerSum sum;
  const auto composite = [&](std::span<const std::byte> some) {
    int delivered = -1;
    std::vector<float> rgba;
    sum.begin_frame(*frame, 0);
    sum.add(some);
    sum.deliver([&](int tile, const Bytes& body) {
      delivered = tile;
      rgba.resize((body.size() - sizeof(Header)) / sizeof(float));
      std::memcpy(rgba.data(), body.data() + sizeof(Header), rgba.size() * sizeof(float));
    });
    return std::pair(delivered, std::vector<float>(rgba.begin() + 20, rgba.begin() + 28));
  };
  const auto [tile, pixels] = composite(bytes);
  CHECK(tile == 1);
  CHECK(pixels == std::vector<float>{0.375F, 0.75F, 0, 0.75F, 1, 0, 0, 1});

  CHECK_THROWS_WITH(composite(std::span(bytes).first(60)), Catch::Contains("no layers of its tiles"));
  constexpr std::size_t place_of_run = 16;  // another one may be right
  for (std::size_t at = 0; at < 24; ++at)
    for (const auto value : {std::byte{0xff}, std::byte{0x7f}}) {
      if (at == place_of_run) continue;
      Bytes damaged = bytes;
      damaged[at] = value;
      CHECK_THROWS_AS(composite(damaged), RunError);
    }
}
