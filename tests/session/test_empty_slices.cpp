#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/scenes.hpp"
#include "volume/cell_ranges.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

struct Volume {
  Grid grid;
  std::vector<std::byte> voxels;
  std::unique_ptr<VolumeSource> source() const { return memory_source(grid, voxels); }
};
/// 12 slices of 10 x 10 voxels along z; `value(z, k)` of the slice's k-th voxel.
template <class T, class Value>
Volume slices_of(ScalarType type, const Value& value) {
  Volume volume{make_grid({10, 10, 12}, type), {}};
  auto& [grid, voxels] = volume;
  voxels.resize(grid.bytes());
  for (int z = 0; z < 12; ++z)
    for (int k = 0; k < 100; ++k) {
      const T v = value(z, k);
      std::memcpy(voxels.data() + std::size_t(100 * z + k) * sizeof(T), &v, sizeof(T));
    }
  return volume;
}

FrameSpec from_above() {
  FrameSpec spec{.how = Splats{}};
  spec.shown.width = spec.shown.height = spec.division.region_size = 40;
  spec.shown.transfer_function = ramp(100, 200, 0.5);
  spec.shown.camera.elevation = 75;
  spec.shown.camera.azimuth = 20;
  return spec;
}

}  // namespace

TEST_CASE("a token goes through the slices only that may have something visible") {
  const Volume volume = slices_of<std::uint8_t>(ScalarType::uint8, [](int z, int k) {
    return z == 3 || z == 4 || z == 9 ? std::uint8_t(80 + k) : std::uint8_t(20);
  });
  const auto source = volume.source();
  FrameSpec spec = from_above();
  for (const double elevation : {75.0, -75.0}) {
    spec.shown.camera.elevation = elevation;
    const FrameResult alone = render_loopback(*source, spec, 1, 1);
    CHECK(alone.stats.total().slices == 3);
    CHECK(alone.stats.total().payloads_sent == 3);
    for (const int gps : {2, 3, 5, 12, 14}) {
      INFO(elevation << ' ' << gps);
      const FrameResult result = render_loopback(*source, spec, gps, 1);
      const NodeStats total = result.stats.total();
      CHECK(result.image == alone.image);
      CHECK(total.slices == 3);
      CHECK(total.tokens_issued == 1);
      CHECK(total.tokens_passed == 2);
    }
  }
}

TEST_CASE("when nothing can be visible a token goes through one slice") {
  const Volume volume = slices_of<std::uint8_t>(ScalarType::uint8, [](int, int) { return std::uint8_t(20); });
  const auto source = volume.source();
  for (const int gps : {1, 2, 5}) {
    const FrameResult result = render_loopback(*source, from_above(), gps, 2);
    CHECK(result.image == Image(40, 40));
    const NodeStats total = result.stats.total();
    CHECK(total.slices == 1);
    CHECK(total.tokens_issued == 1);
    CHECK(total.tokens_passed == 0);
    CHECK(total.payloads_sent == 0);
    CHECK(total.tiles == 0);
  }
}

TEST_CASE("other transfer functions and undersampled frames go through other slices") {
  const Volume volume = slices_of<std::uint8_t>(ScalarType::uint8, [](int z, int k) {
    return std::uint8_t(z < 4 ? 20 : z < 8 ? 120 + k : 230);
  });
  const auto source = volume.source();
  const auto slices = [&](double low, double high, int factor) {
    FrameSpec spec = from_above();
    spec.shown.transfer_function = ramp(low, high, 0.5);
    spec.shown.transfer_function.opacities.push_back({high, 0.0});
    spec.shown.reduction.factor = factor;
    return render_loopback(*source, spec, 2, 1).stats.total().slices;
  };
  CHECK(slices(0, 100, 1) == 4);
  CHECK(slices(100, 225, 1) == 4);
  CHECK(slices(100, 240, 1) == 8);
  CHECK(slices(0, 100, 2) == 2);
  CHECK(slices(100, 240, 4) == 2);
}

TEST_CASE("frames with other transfer functions may be in flight together") {
  const Volume volume = slices_of<std::uint8_t>(ScalarType::uint8, [](int z, int k) {
    return std::uint8_t(z < 4 ? 20 : z < 8 ? 120 + k : 230);
  });
  const auto spec_of = [](std::size_t k) {
    const double low = std::array{0, 100, 225, 0, 150}[k % 5];
    FrameSpec spec = from_above();
    spec.shown.transfer_function = ramp(low, low + 20, 0.5);
    spec.shown.transfer_function.opacities.push_back({low + 25, 0.0});
    return spec;
  };
  std::vector<FrameSpec> specs;
  std::vector<Image> alone;
  for (std::size_t k = 0; k < 20; ++k) specs.push_back(spec_of(k));
  for (std::size_t k = 0; k < 5; ++k)
    alone.push_back(render_loopback(*volume.source(), specs[k], 1, 1).image);
  std::size_t seen = 0;
  const auto compare = [&](FrameResult&& result) { CHECK(result.image == alone[seen++ % 5]); };
  render_directed(*volume.source(), needed_to_render(from_above(), volume.grid), {.gps = 3, .renderers = 2},
                  director_of(specs, compare), {}, {.frames_in_flight = 4, .look_ahead = 3});
  CHECK(seen == 20);
}

TEST_CASE("infinities are in a slice's range, and slices of not-a-number are transparent") {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const Volume volume = slices_of<float>(ScalarType::float32, [&](int z, int k) {
    if (z == 2) return std::nanf("");
    if (z == 5 && k == 7) return infinity;
    if (z == 6 && k == 3) return std::nanf("");
    return z == 6 ? 150.0F : -infinity;
  });
  const FrameResult result = render_loopback(*volume.source(), from_above(), 3, 1);
  CHECK(result.stats.total().slices == 2);
  CHECK(result.stats.total().visible_voxels == 100);
}

TEST_CASE("a slice's range is that of its values, whatever their type") {
  const auto range_of = [](ScalarType type, const auto& values) {
    SliceView view{Axis::y, 4,    int(values.size()),
                   1,       type, reinterpret_cast<const std::byte*>(values.data())};
    const SliceRange range = slice_range(view);
    CHECK(range.axis == Axis::y);
    CHECK(range.slice == 4);
    return std::pair(range.low, range.high);
  };
  CHECK(range_of(ScalarType::int8, std::vector<std::int8_t>{-3, -128, 5}) == std::pair(-128.0, 5.0));
  CHECK(range_of(ScalarType::uint16, std::vector<std::uint16_t>{65535}) == std::pair(65535.0, 65535.0));
  CHECK(range_of(ScalarType::float64, std::vector<double>{2, std::nan(""), -1}) == std::pair(-1.0, 2.0));
  const auto none = range_of(ScalarType::float32, std::vector<float>{std::nanf("")});
  CHECK(none.first > none.second);
}
