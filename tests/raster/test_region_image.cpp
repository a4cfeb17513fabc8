#include "raster/region_image.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

constexpr int width = 37, height = 20;

std::vector<float> tile_of(const RegionImage& image) {
  std::vector<float> tile(std::size_t(4) * width * height, -1.0F);
  image.read_tile(tile);
  return tile;
}

bool is_transparent(const std::vector<float>& tile) {
  return std::all_of(tile.begin(), tile.end(), [](float value) { return value == 0; });
}

void fill(RegionImage& image, int columns, float value) {
  float* pixels = image.pixels();
  for (int y = 0; y < height; ++y) std::fill_n(pixels + y * image.row_floats(), 4 * columns, value);
}

}  // namespace

TEST_CASE("a region's image is transparent until its pixels are asked for, in every frame") {
  RegionImage image({5, 7, 5 + width, 7 + height});
  CHECK(is_transparent(tile_of(image)));
  for (int frame = 0; frame < 2; ++frame) {
    image.begin_frame(0);
    CHECK_FALSE(image.touched());
    CHECK(is_transparent(tile_of(image)));
    image.pixels();
    CHECK(image.touched());
    CHECK(is_transparent(tile_of(image)));
    fill(image, width, 0.5F);
    CHECK(image.pixels()[0] == 0.5F);
    const auto tile = tile_of(image);
    CHECK(std::all_of(tile.begin(), tile.end(), [](float value) { return value == 0.5F; }));
  }
}

TEST_CASE("tiles whose pixels let through less than the threshold are found opaque after some slices") {
  RegionImage image({0, 0, width, height});
  image.begin_frame(0.01F);
  fill(image, 33, 0.999F);
  for (int slice = 0; slice < 8; ++slice) image.slices_composited();
  CHECK(image.opaque_tiles().opaque() == 4);  // of three columns the last has transparent pixels
  CHECK(image.opaque_tiles().is_opaque(1, 1));
  CHECK_FALSE(image.opaque_tiles().is_opaque(2, 0));
  image.begin_frame(0);
  CHECK(image.opaque_tiles().opaque() == 0);
  fill(image, width, 1);
  for (int slice = 0; slice < 8; ++slice) image.slices_composited();
  CHECK(image.opaque_tiles().opaque() == 0);
}

TEST_CASE("a pixel that lets through just the threshold is not opaque") {
  for (const float alpha : {0.75F, std::nextafter(0.75F, 1.0F)}) {
    RegionImage image({0, 0, width, height});
    image.begin_frame(0.25F);
    fill(image, width, alpha);
    image.slices_composited(8);
    CHECK((image.opaque_tiles().opaque() > 0) == (alpha > 0.75F));
  }
}
