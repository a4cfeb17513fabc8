#include "raster/opaque_tiles.hpp"
#include "splat/scene.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// Slices that leave the lower part of a region transparent.
std::vector<std::vector<Placed>> half_covered(const Footprint& footprint, int slices) {
  std::vector<std::vector<Placed>> scene;
  for (int z = 0; z < slices; ++z)
    scene.push_back(random_splats(footprint, 1500, -4, -4, 68, 40, unsigned(z), 0.9F));
  return scene;
}

std::vector<float> picture(const std::vector<std::vector<Placed>>& scene, const Footprint& footprint,
                           float threshold, bool leave_out_hidden, DrawCounts& counts) {
  RegionPainter painter(0, 0, 64, 64);
  painter.begin_frame(footprint, threshold);
  for (const auto& slice : scene) {
    for (const auto& placed : slice) {
      const auto reach = kernel_reach(footprint);
      const PixelWindow window = pixel_window({placed.splat.anchor_x, placed.splat.anchor_y, 0, 0}, reach);
      if (leave_out_hidden && painter.opaque_tiles().hides(window.x0, window.y0, window.x1, window.y1))
        continue;
      const auto drawn = draw_all(painter, {placed});
      counts.drawn += drawn.drawn;
      counts.hidden += drawn.hidden;
    }
    painter.composite();
  }
  return tile_of(painter, 64, 64);
}

}  // namespace

TEST_CASE("leaving out what opaque tiles hide changes no bit, and the threshold bounds the error",
          "[painter]") {
  const auto footprint = footprint_of({1.17, 0.4, 0.7, 0.9, 1});
  const auto scene = half_covered(footprint, 80);
  DrawCounts all, masked, culled;
  const auto exact = picture(scene, footprint, 0, false, all);
  const auto frozen = picture(scene, footprint, 1.0F / 512, false, masked);
  CHECK(all.hidden == 0);
  CHECK(masked.hidden > all.drawn / 8);
  CHECK(picture(scene, footprint, 1.0F / 512, true, culled) == frozen);
  CHECK(culled.hidden == 0);
  CHECK(culled.drawn == masked.drawn);
  float largest = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) largest = std::max(largest, std::abs(exact[i] - frozen[i]));
  CHECK(largest > 0);
  CHECK(largest < 1.0F / 512);
}

TEST_CASE("a sum that goes from region to region shows what each region alone shows", "[painter]") {
  const auto footprint =
      footprint_of(GENERATE(Lattice{1.6, 0.2, 0.8, 0.1, 1}, Lattice{30, 0.2, 0.8, 0.1, 1}));
  RegionImage left({0, 0, 32, 48}), right({32, 0, 102, 20});
  RegionPainter alone(32, 0, 70, 20);
  for (int frame = 0; frame < 2; ++frame) {
    for (RegionImage* image : {&left, &right}) image->begin_frame(0);
    SplatSum sum(footprint, {0, 0, 70, 48});
    alone.begin_frame(footprint);
    for (unsigned z = 0; z < 5; ++z) {
      const auto slice = random_splats(footprint, 400, -5, -5, 110, 55, z, 0.2F);
      for (RegionImage* image : {&left, &right}) {
        sum.begin(*image);
        draw_all(sum, slice);
        sum.composite();
      }
      draw_all(alone, slice);
      alone.composite();
    }
    CHECK(same_bits(tile_of(right, 70, 20), tile_of(alone, 70, 20)));
  }
}
