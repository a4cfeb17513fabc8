#include <limits>

#include "formats/captured_log.hpp"
#include "formats/channels.hpp"
#include "formats/files.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/message_of.hpp"

using namespace files;
using namespace ringsplat::detail;

namespace {

template <class T>
std::vector<T> taken(ScalarType type, int components, ChannelChoice choice, const std::vector<T>& voxels) {
  std::vector<T> out(voxels.size() / std::size_t(components));
  take_channel(type, components, choice, std::as_bytes(std::span(voxels)),
               std::as_writable_bytes(std::span(out)));
  return out;
}

}  // namespace

TEST_CASE("a chosen channel has the stored numbers of every voxel", "[channels]") {
  const std::vector<float> voxels{1, 2, 3, 4, 5, 6};
  CHECK((taken<float>(ScalarType::float32, 3, {0}, voxels) == std::vector<float>{1, 4}));
  CHECK((taken<float>(ScalarType::float32, 3, {2}, voxels) == std::vector<float>{3, 6}));
  CHECK((taken<float>(ScalarType::float32, 2, {1}, voxels) == std::vector<float>{2, 4, 6}));
  CHECK((taken<short>(ScalarType::int16, 2, {1}, {-1, -2, 3, 4}) == std::vector<short>{-2, 4}));
}

TEST_CASE("luminance weighs as ITU-R BT.709, rounds, and keeps greys to the end of the type", "[channels]") {
  using Bytes = std::vector<std::uint8_t>;
  CHECK((taken<std::uint8_t>(ScalarType::uint8, 3, {}, {255, 0, 0, 0, 255, 0, 0, 0, 255}) ==
         Bytes{54, 182, 18}));
  CHECK((taken<std::uint8_t>(ScalarType::uint8, 4, {}, {255, 255, 255, 0, 7, 7, 7, 255}) == Bytes{255, 7}));
  CHECK((taken<std::uint16_t>(ScalarType::uint16, 3, {}, {65535, 65535, 65535, 10000, 0, 0}) ==
         std::vector<std::uint16_t>{65535, 2126}));
  const auto low = std::numeric_limits<std::int32_t>::min(), high = std::numeric_limits<std::int32_t>::max();
  CHECK((taken<std::int32_t>(ScalarType::int32, 3, {}, {low, low, low, high, high, high, -10, 0, 0}) ==
         std::vector<std::int32_t>{low, high, -2}));
  CHECK(taken<float>(ScalarType::float32, 3, {}, {1, 0, 0.5F})[0] == Approx(0.2126 + 0.0361));
}

TEST_CASE("colours are shown by luminance with a warning that names --channel, vectors need a choice",
          "[channels]") {
  CHECK(are_colours(ScalarType::uint8, 3));
  CHECK(are_colours(ScalarType::uint16, 4));
  CHECK_FALSE(are_colours(ScalarType::uint8, 2));
  CHECK_FALSE(are_colours(ScalarType::int16, 3));
  CHECK_FALSE(are_colours(ScalarType::float32, 3));
  {
    const CapturedLog log;
    CHECK_FALSE(choose_channel("", 3, true, "luminous.nrrd"));
    CHECK(says(log.text(), "luminous.nrrd: voxels are colours"));
    CHECK(says(log.text(), "--channel r, g or b"));
  }
  const CapturedLog log;
  CHECK(choose_channel("r", 3, true, "a") == 0);
  CHECK(choose_channel("a", 4, true, "a") == 3);
  CHECK(choose_channel("1", 3, true, "a") == 1);
  CHECK(choose_channel("5", 6, false, "a") == 5);
  CHECK(log.text().empty());

  const auto complaint = [](const char* channel, int components, bool colours) {
    return message_of([&] { choose_channel(channel, components, colours, "f.nrrd"); });
  };
  const auto vector = complaint("", 6, false);
  CHECK(says(vector, "f.nrrd: a voxel is a vector of 6 numbers"));
  CHECK(says(vector, "--channel: a number from 0 to 5"));
  CHECK(says(complaint("6", 6, false), "--channel 6: f.nrrd has no such channel"));
  CHECK(says(complaint("-1", 6, false), "no such channel"));
  CHECK(says(complaint("r", 6, false), "its channels are a number from 0 to 5"));
  CHECK(says(complaint("a", 3, true), "its channels are r, g, b or a number from 0 to 2"));
  CHECK(says(complaint("rg", 3, true), "no such channel"));
}

TEST_CASE("a channel of a source is read whole, by slice and by layer", "[channels]") {
  Grid grid;
  grid.dims = {nx, ny, nz};
  grid.type = ScalarType::int16;
  const std::string voxels = interleaved(3, 1);
  const auto wide = interleaved_grid(grid, 3, "a");
  CHECK(wide.dims == glm::ivec3(3 * nx, ny, nz));
  const auto source = channel_source(memory_source(wide, std::as_bytes(std::span(voxels))), grid, 3, 1);
  CHECK(is_sample(*source));
  REQUIRE(!source->facts().empty());

  grid.dims = {std::numeric_limits<int>::max() / 2, 1, 1};
  CHECK(says(message_of([&] { interleaved_grid(grid, 3, "f.nrrd"); }), "f.nrrd: rows of"));
}
