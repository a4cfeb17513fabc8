#include <fmt/format.h>

#include "classify/empty_space.hpp"
#include "net/message.hpp"
#include "splat_engine/row_band.hpp"
#include "splat_engine/splat_engine.hpp"
#include "support/catch.hpp"
#include "support/views.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr std::array team_sizes{1, 2, 3, 8};

LoopbackOptions shuffled(int threads) {
  return {.seed = std::uint64_t(threads), .reorder = true, .max_delay = 3};
}

/// All that an encoder makes from a volume, slice by slice.
std::vector<EncodedStep> encode_all(VolumeSource& source, const FrameSpec& spec, int renderers, int threads) {
  SoloCollectives solo;
  const Grid grid = source.grid();
  OpenedVolume volume{grid, true, synth_source("ball", grid)};
  auto stores = deal_slices(volume, {}, {1, {0}, solo});
  const auto frame = std::make_shared<SplatFrame>(spec, make_geometry(spec, grid), 1, renderers);
  ThreadTeam team(threads);
  EmptySpace empty_space;
  const auto encoder = make_splat_encoder(frame, renderers, stores.at(0), empty_space, team);
  std::vector<EncodedStep> slices;
  for (int step = 0; step < frame->geometry.slices; ++step) {
    encoder->begin(step);
    while (!encoder->work()) {
    }
    slices.push_back(encoder->finish());
  }
  return slices;
}

/// A payload without the space for a message's header, whose bytes are undefined.
Bytes body_of(Bytes payload) {
  if (!payload.empty()) payload.erase(payload.begin(), payload.begin() + sizeof(Header));
  return payload;
}

}  // namespace

TEST_CASE("rows are cut into bands of about as many voxels") {
  const Grid grid = make_grid({128, 128, 3});
  SoloCollectives solo;
  OpenedVolume volume{grid, true, synth_source("ball", grid)};
  auto stores = deal_slices(volume, {}, {1, {0}, solo});
  const SliceView slice = stores.at(0).slice(Axis::z, 1);
  const SliceRuns runs(BlockRanges(slice), ramp(128, 255, 0.5), slice.width);
  const auto voxels = [&](int first, int end) {
    int sum = 0;
    for (int row = first; row < end; ++row)
      for (const ColumnRun& run : runs.of_row(row)) sum += run.end - run.first;
    return sum;
  };
  const int all = voxels(0, 128);
  REQUIRE(all > 3000);
  REQUIRE(all < 128 * 128);
  for (const int most : {1, 2, 3, 5, 12}) {
    const auto bounds = row_bounds(runs, 128, most);
    REQUIRE(int(bounds.size()) == most + 1);
    CHECK(bounds.front() == 0);
    CHECK(bounds.back() == 128);
    for (std::size_t k = 0; k + 1 < bounds.size(); ++k) {
      CHECK(bounds[k] < bounds[k + 1]);
      CHECK(std::abs(voxels(bounds[k], bounds[k + 1]) - all / most) <= 128);
    }
  }
  CHECK(int(row_bounds(runs, 128, 1024).size()) <= all / 256 + 1);  // too few voxels for more
  CHECK(row_bounds(SliceRuns(BlockRanges(slice), constant_opacity(0.5, 400), slice.width), 128, 4) ==
        std::vector<int>{0});
}

TEST_CASE("payloads are the same bytes whatever the number of threads", "[threads]") {
  const auto source = synth_source("ball", make_grid({70, 61, 24}));
  for (const auto plane : {ImagePlane::screen, ImagePlane::slices})
    for (const int region : {40, 4096})
      for (const double zoom : {1.2, 8.0}) {
        FrameSpec spec = oblique_view(300, 280, 32);
        spec.shown.camera = {.azimuth = 33, .elevation = 21, .zoom = zoom};
        spec.shown.width = spec.shown.height = 700;
        spec.as<Splats>().image_plane = plane;
        spec.division.region_size = region;
        const auto alone = encode_all(*source, spec, 3, 1);
        for (const int threads : {2, 3, 8}) {
          INFO(
              fmt::format("plane {}, regions of {}, zoom {}, {} threads", int(plane), region, zoom, threads));
          const auto shared = encode_all(*source, spec, 3, threads);
          REQUIRE(shared.size() == alone.size());
          std::uint64_t visible = 0;
          for (std::size_t k = 0; k < alone.size(); ++k) {
            for (std::size_t r = 0; r < alone[k].parts.size(); ++r) {
              const EncodedPart &one = alone[k].parts[r], &other = shared[k].parts[r];
              REQUIRE(body_of(other.payload) == body_of(one.payload));
              REQUIRE(other.items == one.items);
              REQUIRE(other.passes == one.passes);
              REQUIRE(other.tiles == one.tiles);
            }
            REQUIRE(shared[k].counts.visible == alone[k].counts.visible);
            REQUIRE(shared[k].counts.voxels == alone[k].counts.voxels);
            visible += alone[k].counts.visible;
          }
          REQUIRE(visible > 1000);
        }
      }
}

TEST_CASE("the image and the counts are the same whatever the number of threads", "[threads]") {
  const auto source = synth_source("ball", make_grid({65, 57, 60}));
  for (const auto plane : {ImagePlane::screen, ImagePlane::slices})
    for (const int region : {9, 32, 4096}) {
      FrameSpec spec = oblique_view(300, 280, 32);
      spec.as<Splats>().image_plane = plane;
      spec.division.region_size = region;
      spec.shown.opaque_threshold = 0;  // hidden counts depend on when GPs get the news
      const auto alone = render_loopback(*source, spec, 1, 1);
      REQUIRE(brightest(alone.image) > 0.1F);
      const NodeStats counted = alone.stats.total();
      for (const int threads : team_sizes) {
        INFO(fmt::format("plane {}, regions of {}, {} threads", int(plane), region, threads));
        const auto one =
            render_loopback(*source, spec, 1, 1, {}, Placement::colocated, {}, {.threads_per_rank = threads});
        REQUIRE(one.image == alone.image);
        const NodeStats total = one.stats.total();
        CHECK(total.splats_drawn == counted.splats_drawn);
        CHECK(total.splats_clipped == counted.splats_clipped);
        CHECK(total.splats_sent == counted.splats_sent);
        CHECK(total.payload_bytes_sent == counted.payload_bytes_sent);
        CHECK(total.visible_voxels == counted.visible_voxels);
      }
    }
}

TEST_CASE("threads keep the bits on any layout, with messages in any order", "[threads]") {
  const auto source = synth_source("ball", make_grid({65, 57, 60}));
  for (const auto plane : {ImagePlane::screen, ImagePlane::slices}) {
    FrameSpec spec = oblique_view(300, 280, 32);
    spec.as<Splats>().image_plane = plane;
    const auto alone = render_loopback(*source, spec, 1, 1);
    REQUIRE(brightest(alone.image) > 0.1F);
    for (const int threads : team_sizes)
      for (const auto& [gps, renderers] : {std::pair{1, 1}, {3, 2}, {2, 5}})
        for (const auto placement : {Placement::dedicated, Placement::colocated}) {
          INFO(fmt::format("plane {}, {} threads, {} GPs, {} Renderers, {}", int(plane), threads, gps,
                           renderers, placement == Placement::dedicated ? "dedicated" : "colocated"));
          const auto shared = render_loopback(*source, spec, gps, renderers, shuffled(threads), placement, {},
                                              {.threads_per_rank = threads});
          REQUIRE(shared.image == alone.image);
          // Seconds are wall-clock time, not sums over threads.
          for (const NodeStats& renderer : shared.stats.renderers) {
            CHECK(renderer.drawing >= 0);
            CHECK(renderer.compositing >= 0);
            CHECK(renderer.drawing + renderer.compositing <= shared.stats.seconds + 0.001);
          }
        }
  }
}

TEST_CASE("threads keep the bits of opaque pixels", "[threads]") {
  const auto source = synth_source("ball", make_grid({65, 57, 60}));
  for (const auto plane : {ImagePlane::screen, ImagePlane::slices}) {
    FrameSpec spec = oblique_view(300, 280, 32);
    spec.as<Splats>().image_plane = plane;
    spec.shown.transfer_function = ramp(1, 20, 1.0);
    const auto alone = render_loopback(*source, spec, 1, 1);
    if (plane == ImagePlane::screen) CHECK(alone.stats.total().splats_hidden > 0);
    for (const int threads : team_sizes)
      REQUIRE(render_loopback(*source, spec, 2, 2, shuffled(threads), Placement::colocated, {},
                              {.threads_per_rank = threads})
                  .image == alone.image);
  }
}

TEST_CASE("threads paint sheets into one image with the same bits", "[threads]") {
  const auto source = synth_source("ball", make_grid({65, 57, 60}));
  FrameSpec spec = oblique_view(300, 280, 4096);
  spec.how = Sheets{};
  const auto alone = render_loopback(*source, spec, 1, 1);
  REQUIRE(brightest(alone.image) > 0.1F);
  for (const int threads : team_sizes)
    CHECK(render_loopback(*source, spec, 1, 1, {}, Placement::colocated, {}, {.threads_per_rank = threads})
              .image == alone.image);
}

TEST_CASE("frames that are dropped while threads draw them leave nothing behind", "[threads]") {
  const auto source = synth_source("ball", make_grid({33, 31, 32}));
  std::vector<FrameSpec> specs(9, oblique_view(300, 280, 32));
  for (std::size_t k = 0; k < specs.size(); ++k) {
    specs[k].shown.camera.azimuth = 52.0 * double(k);
    specs[k].as<Splats>().image_plane = k % 2 == 0 ? ImagePlane::screen : ImagePlane::slices;
  }
  std::vector<Image> alone;
  for (const auto& spec : specs) alone.push_back(render_loopback(*source, spec, 1, 1).image);
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const int threads = team_sizes[seed % team_sizes.size()], patience = int(11 * seed % 120);
    INFO(fmt::format("seed {}, {} threads", seed, threads));
    std::size_t kept = 0;
    std::map<std::int64_t, int> questions;
    Director director = director_of(specs, [&](FrameResult&& r) {
      kept += r.spec.frame % 3 != 1 ? 1 : 0;
      REQUIRE(r.image == alone[std::size_t(r.spec.frame)]);
    });
    director.unwanted = [&](const FrameSpec& spec) {
      return spec.frame % 3 == 1 && ++questions[spec.frame] > patience;
    };
    render_directed(*source, {}, {1 + int(seed % 3), 1 + int(seed % 2)}, std::move(director),
                    {.seed = seed, .reorder = true, .max_delay = int(seed % 6)},
                    {.frames_in_flight = 1 + int(seed % 3)}, {.threads_per_rank = threads});
    CHECK(kept == 6);
  }
}
