#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "frame/frame_geometry.hpp"
#include "support/catch.hpp"
#include "support/scenes.hpp"
#include "volume/synth.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

const glm::ivec3 dims{40, 36, 32};

/// A picture of side² pixels that shows the turned volume with its centre at `centre` and `scale` pixels a
/// voxel.
FrameSpec placed(double scale, glm::dvec2 centre, int side) {
  const glm::dvec3 right{0.8, 0.6, 0}, down{0.36, -0.48, -0.8}, away{-0.48, 0.64, -0.6};
  const glm::dvec3 middle = 0.5 * glm::dvec3(dims - 1);
  FrameSpec spec{.how = Splats{}};
  spec.shown.width = spec.shown.height = side;
  spec.shown.transfer_function = ramp(0, 255, 0.4);
  spec.shown.camera.matrix.emplace();
  const glm::dvec3 rows[] = {right * scale, down * scale, away * scale};
  const double offsets[] = {centre.x, centre.y, 0};
  for (std::size_t row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      (*spec.shown.camera.matrix)[4 * row + std::size_t(column)] = rows[row][column];
    (*spec.shown.camera.matrix)[4 * row + 3] = offsets[row] - glm::dot(rows[row], middle);
  }
  return spec;
}

/// In columns and rows of regions.
PixelRect all(const Regions& regions) { return {0, 0, regions.columns(), regions.rows()}; }

/// Who draws the regions of a block, of which nothing is known.
std::vector<int> owners_of(const Regions& regions, const PixelRect& block, int renderers, int dealt_to) {
  FrameGeometry geometry;
  geometry.regions = regions;
  geometry.reached = block;
  geometry.dealt_to = dealt_to;
  return geometry.owners(renderers);
}

/// The busiest Renderer's splats.
double most_splats(const FrameResult& result) {
  std::uint64_t most = 0;
  for (const NodeStats& renderer : result.stats.renderers) most = std::max(most, renderer.splats_drawn);
  return double(most);
}

}  // namespace

TEST_CASE("regions are dealt evenly over what the volume covers of the screen, wherever it lies") {
  for (const glm::dvec2 centre : {glm::dvec2(256, 256), {512, 512}, {60, 200}, {470, 20}}) {
    for (const double scale : {0.5, 3.0, 9.0}) {
      for (const int renderers : {1, 2, 3, 8, 16, 60}) {
        FrameSpec spec = placed(scale, centre, 512);
        spec.division.dealt_to = renderers;
        const FrameGeometry geometry = make_geometry(spec, make_grid(dims));
        const std::vector<int> owners = geometry.owners(renderers);
        auto least = std::ranges::count(owners, 0), most = least, sum = 0 * least;
        for (int k = 0; k < renderers; ++k) {
          const auto owned = std::ranges::count(owners, k);
          least = std::min(least, owned);
          most = std::max(most, owned);
          sum += owned;
        }
        INFO(fmt::format("centre {}, {}, scale {}, {} Renderers", centre.x, centre.y, scale, renderers));
        CHECK(sum == geometry.reached.width() * geometry.reached.height());
        CHECK(most <= least + 1);
        CHECK((renderers > 1 || geometry.regions == Regions(512, 512, 128)));
        spec.division.region_size = 100;
        CHECK(make_geometry(spec, make_grid(dims)).regions == Regions(512, 512, 100));
      }
    }
  }
}

TEST_CASE("Renderers have as many regions as any other or one fewer, wherever in the picture", "[regions]") {
  for (const int columns : {1, 2, 4, 5, 6, 12, 16}) {
    for (int renderers = 1; renderers <= 24; ++renderers) {
      INFO(columns << " regions in a row, " << renderers << " Renderers");
      const Regions regions(columns * 10, 70, 10);
      std::vector<int> owned(std::size_t(renderers), 0);
      for (const int owner : owners_of(regions, all(regions), renderers, renderers))
        ++owned[std::size_t(owner)];
      CHECK(*std::max_element(owned.begin(), owned.end()) <=
            *std::min_element(owned.begin(), owned.end()) + 1);
    }
  }
}

TEST_CASE("regions dealt to some of the Renderers lie with some at even distances", "[regions]") {
  const Regions regions(60, 70, 10);
  for (int renderers = 1; renderers <= 24; ++renderers) {
    for (int dealt_to = 1; dealt_to <= renderers; ++dealt_to) {
      INFO(dealt_to << " of " << renderers << " Renderers");
      const std::vector<int> owners = owners_of(regions, all(regions), renderers, dealt_to),
                             few = owners_of(regions, all(regions), dealt_to, dealt_to);
      for (int region = 0; region < regions.count(); ++region)
        REQUIRE(owners[std::size_t(region)] == few[std::size_t(region)] * renderers / dealt_to);
    }
  }
}

TEST_CASE("a block of regions is dealt as if it were the picture, and the others are nobody's", "[regions]") {
  const Regions regions(90, 70, 10);
  for (const PixelRect block :
       {PixelRect{0, 0, 9, 7}, {2, 1, 7, 6}, {8, 6, 9, 7}, {0, 3, 9, 4}, {4, 4, 4, 4}}) {
    for (int renderers = 1; renderers <= 12; ++renderers) {
      INFO(block.x0 << ' ' << block.y0 << ' ' << block.x1 << ' ' << block.y1 << ", " << renderers);
      const Regions part(std::max(block.width(), 1), std::max(block.height(), 1), 1);
      const std::vector<int> owners = owners_of(regions, block, renderers, renderers),
                             alone = owners_of(part, all(part), renderers, renderers);
      for (int y = 0; y < regions.rows(); ++y) {
        for (int x = 0; x < regions.columns(); ++x) {
          const bool inside = x >= block.x0 && x < block.x1 && y >= block.y0 && y < block.y1;
          const int owner = owners[std::size_t(y * regions.columns() + x)];
          if (inside)
            REQUIRE(owner == alone[std::size_t((y - block.y0) * block.width() + x - block.x0)]);
          else
            REQUIRE(owner == nobody);
        }
      }
    }
  }
}

TEST_CASE("regions are small where large ones would leave Renderers idle") {
  const auto source = synth_source("ball", make_grid(dims));
  const auto most_of_large = [&](glm::dvec2 centre, int renderers) {
    FrameSpec spec = placed(4, centre, 256);
    const double chosen = most_splats(render_loopback(*source, spec, 1, renderers));
    spec.division.region_size = 128;
    return chosen / most_splats(render_loopback(*source, spec, 1, renderers));
  };
  for (const int renderers : {2, 3, 4, 8}) {
    INFO(renderers << " Renderers");
    CHECK(most_of_large({128, 128}, renderers) <= 1.0);
    CHECK(most_of_large({256, 256}, renderers) < 0.8);
    CHECK(most_of_large({0, 256}, renderers) < 0.8);
  }
  CHECK(most_of_large({256, 256}, 1) == 1.0);
}

TEST_CASE("where the volume lies in the picture changes who draws it, and no bit") {
  const auto source = synth_source("jack", make_grid(dims));
  const std::vector<glm::dvec2> centres{{75, 75}, {140, 150}, {3, 70}, {20, -12}, {-9, 160}};
  for (const glm::dvec2 centre : centres) {
    for (const double scale : {0.3, 1.0, 2.2}) {
      for (const ImagePlane plane : {ImagePlane::screen, ImagePlane::slices}) {
        FrameSpec spec = placed(scale, centre, 150);
        spec.as<Splats>().image_plane = plane;
        for (const double radius : {0.5, 1.6, 3.0}) {
          spec.as<Splats>().kernel_radius = radius;
          const Image alone = render_loopback(*source, spec, 1, 1).image;
          const int renderers = 2 + int(radius * 2);
          INFO(fmt::format("centre {}, {}, scale {}, {}, radius {}, {} Renderers", centre.x, centre.y, scale,
                           name(plane), radius, renderers));
          for (const int region : {0, 7}) {
            spec.division.region_size = region;
            REQUIRE(render_loopback(*source, spec, 2, renderers).image == alone);
          }
          REQUIRE(render_loopback(*source, spec, 3, renderers, {}, Placement::colocated).image == alone);
        }
      }
    }
  }
}

TEST_CASE("a volume beside the picture costs no message, and the picture is empty") {
  const auto source = synth_source("jack", make_grid(dims));
  for (const ImagePlane plane : {ImagePlane::screen, ImagePlane::slices}) {
    FrameSpec spec = placed(1, {400, 75}, 150);
    spec.as<Splats>().image_plane = plane;
    const FrameResult result = render_loopback(*source, spec, 2, 3);
    CHECK(result.stats.total().tokens_issued == 0);
    CHECK(result.stats.total().visible_voxels == 0);
    CHECK(result.stats.total().voxels_outside > 0);
    CHECK(result.stats.total().payloads_sent == 0);
    CHECK(result.stats.total().tiles == 0);
    CHECK(std::all_of(result.image.rgba.begin(), result.image.rgba.end(), [](float v) { return v == 0; }));
  }
}
