#include <cstring>
#include <random>

#include "sheet_engine/scalar_planes.hpp"
#include "support/catch.hpp"
#include "volume/cell_ranges.hpp"

using namespace ringsplat;

namespace {

/// A payload of a slice of 8-bit voxels; its memory is its own.
struct Made {
  std::vector<std::vector<std::uint8_t>> bytes;
  std::vector<std::byte> voxels;
  SheetPayload payload;
};

Made random_payload(std::mt19937& random, int width, int height) {
  constexpr int side = CellRanges::side;
  Made made;
  SheetPayload& p = made.payload;
  const int columns = CellRanges::blocks_along(width), rows = CellRanges::blocks_along(height);
  p.header.elsewhere = std::uint8_t(random() % 8 == 0 ? 1 : 0);
  p.header.first_row = std::uint16_t(random() % unsigned(rows));
  for (int row = p.header.first_row; row < rows && random() % 4 != 0; ++row) {
    BlockRow span{std::uint16_t(random() % unsigned(columns)), 0};
    span.end = std::uint16_t(span.first + random() % unsigned(columns - span.first + 1));
    p.rows.push_back(span);
    auto& bytes = made.bytes.emplace_back();
    for (int column = span.first; column < span.end; ++column) {
      const bool present = random() % 2 == 0;
      bytes.push_back(std::uint8_t(present ? int(block_present) : int(random() % 3)));
      const int voxels = std::min(side, width - column * side) * std::min(side, height - row * side);
      for (int k = 0; present && k < voxels; ++k) made.voxels.push_back(std::byte(random() % 256));
    }
  }
  p.header.rows = std::uint16_t(p.rows.size());
  for (const auto& bytes : made.bytes) p.bytes.push_back(bytes.data());
  p.voxels = made.voxels;
  return made;
}

constexpr Fillers fillers{3, 250, 120, 0, 0, 0, 0};

/// A plane's numbers and those next to them.
std::vector<double> numbers(const ScalarPlanes& planes, int step, int width, int height, bool floats) {
  std::vector<double> all;
  for (int y = -1; y <= height; ++y)
    for (int x = -1; x <= width; ++x) {
      const std::ptrdiff_t at = y * planes.pitch() + x;
      all.push_back(floats ? double(static_cast<const float*>(planes.plane(step))[at])
                           : double(static_cast<const std::int16_t*>(planes.plane(step))[at]));
    }
  return all;
}

}  // namespace

TEST_CASE("what a plane held before does not show in what is placed there") {
  constexpr int slots = 8;
  std::mt19937 random(5);
  for (const bool floats : {false, true})
    for (const auto& [width, height] : {std::pair{33, 17}, {8, 9}, {1, 40}, {30, 1}, {64, 24}}) {
      PlaneCode code;
      code.floats = floats;
      ScalarPlanes used;
      used.begin_frame(width, height, slots, code, fillers);
      std::vector<std::vector<double>> expected(slots);
      for (int step = 0; step < 60; ++step) {
        const Made made = random_payload(random, width, height);
        const PixelRect all{0, 0, CellRanges::blocks_along(width), CellRanges::blocks_along(height)};
        ScalarPlanes fresh;
        fresh.begin_frame(width, height, slots, code, fillers);
        fresh.place(step, made.payload, ScalarType::uint8, all);
        used.place(step, made.payload, ScalarType::uint8, all);
        CAPTURE(floats, width, height, step);
        expected[std::size_t(step % slots)] = numbers(fresh, step, width, height, floats);
        REQUIRE(numbers(used, step, width, height, floats) == expected[std::size_t(step % slots)]);
        if (step < slots || step % 3 != 0) continue;
        // Then an extrapolation takes a slot that was used.
        used.extrapolate(step + 1, step, step - 1, all);
        const auto &one = expected[std::size_t(step % slots)],
                   &other = numbers(used, step - 1, width, height, floats),
                   &out = numbers(used, step + 1, width, height, floats);
        std::vector<double> beyond(out.size());
        for (std::size_t k = 0; k < out.size(); ++k) beyond[k] = 2 * one[k] - other[k];
        REQUIRE(out == beyond);
      }
    }
}

TEST_CASE("a kept block's labels do not show where it is not needed, and come back") {
  ScalarPlanes planes;
  PlaneCode code;
  code.labelled = true;
  planes.begin_frame(16, 8, 4, code, fillers);
  const auto place = [&planes](int step, std::vector<std::uint8_t> bytes, std::vector<std::byte> voxels) {
    SheetPayload payload;
    payload.header.rows = 1;
    payload.header.plane = 0;
    payload.header.shelf = {0, 1, 1};
    payload.rows = {{0, 2}};
    payload.bytes = {bytes.data()};
    payload.voxels = voxels;
    planes.place(step, payload, ScalarType::uint8, {0, 0, 2, 1});
    return planes.labels(step);
  };
  // The first block's voxels and labels, and the second one's voxels.
  std::vector<std::byte> voxels(192, std::byte{77});
  std::fill_n(voxels.begin() + 64, 64, std::byte{5});
  const auto* labels = place(0, {block_present | block_labelled, block_present}, voxels);
  CHECK(labels[0] == 5);
  CHECK(labels[7 * planes.pitch() + 7] == 5);
  CHECK(labels[8] == 0);
  labels = place(1, {0, block_present | block_kept}, {});
  CHECK(labels[0] > most_tints);
  CHECK(labels[8] == 0);
  CHECK(place(2, {block_present | block_kept, block_present | block_kept}, {})[0] == 5);
}
