#include <cmath>
#include <random>
#include <string>

#include "splat/reference_painter.hpp"
#include "splat/scene.hpp"
#include "splat/voxel_run.hpp"
#include "support/catch.hpp"
#include "support/vector_targets.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// Puts the best instruction set back at a test's end.
struct TargetGuard {
  ~TargetGuard() { use_vector_target(""); }
};

constexpr int width = 83, height = 61, slices = 3;

std::vector<float> paint(const Footprint& footprint, const std::vector<std::vector<Placed>>& scene) {
  RegionPainter painter(0, 0, width, height);
  painter.begin_frame(footprint);
  for (const auto& slice : scene) {
    draw_all(painter, slice);
    painter.composite();
  }
  return tile_of(painter, width, height);
}

std::vector<float> paint_reference(const Footprint& footprint,
                                   const std::vector<std::vector<Placed>>& scene) {
  FloatPainter painter(footprint, width, height);
  for (const auto& slice : scene) {
    for (const auto& placed : slice) painter.draw(placed);
    painter.composite();
  }
  return painter.tile();
}

}  // namespace

TEST_CASE("every instruction set draws the same bits as the plain float32 operations", "[painter][vector]") {
  const TargetGuard guard;
  const double scale = GENERATE(0.05, 1.0, 1.17, 1.3, 2.3, 4.7, 9.0, 19.0, 21.0, 120.0, 4000.0);
  const Lattice lattice{scale, 0.4, GENERATE(1.0, 0.58), 0.9, 1};
  const auto footprint = footprint_of(lattice);
  std::vector<std::vector<Placed>> scene;
  for (unsigned z = 0; z < slices; ++z) {
    const double beyond = std::min(1.2 * footprint.half.x, 5000.0);
    scene.push_back(random_splats(footprint, 150, -beyond, -beyond, width + beyond, height + beyond, z));
    const auto inside = random_splats(footprint, 150, 0, 0, width, height, z + 100);
    scene.back().insert(scene.back().end(), inside.begin(), inside.end());
  }
  const auto expected = paint_reference(footprint, scene);
  const auto targets = vector_targets();
  REQUIRE_FALSE(targets.empty());
  for (const auto& target : targets) {
    use_vector_target(target);
    REQUIRE(vector_target() == target);
    INFO(target << ", scale " << scale);
    if (footprint.half.x < 32) {
      CHECK(same_bits(paint(footprint, scene), expected));
    } else {
      // Rows end where the quadratic, solved in double precision, does; the reference goes on to the last bit
      // of Q > 0.
      const auto tile = paint(footprint, scene);
      for (std::size_t i = 0; i < tile.size(); ++i) REQUIRE(tile[i] == Approx(expected[i]).margin(1e-9));
      use_vector_target(targets.back());
      CHECK(same_bits(tile, paint(footprint, scene)));
    }
  }
}

TEST_CASE("the narrowest vectors are always among those compared", "[painter][vector]") {
  const auto targets = vector_targets();
  CHECK((targets.back() == "SCALAR" || targets.back() == "EMU128" || targets.size() == 1));
}

TEST_CASE("an unknown instruction set leaves the best one in use", "[painter][vector]") {
  const TargetGuard guard;
  use_vector_target("abacus");
  CHECK(vector_target() == vector_targets().front());
}

TEST_CASE("voxels are packed to the nearest", "[payload]") {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> share(0.0F, 1.0F);
  // Ends, what rounds to 0 or to 1, and anything between.
  std::vector<float> rgba{0.0F, 1.0F, 0.5F, 1.0F / 255, 0x1p-25F, 1e-30F, 0.99999994F};
  for (int k = 0; k < 4000; ++k)
    rgba.push_back(k % 3 == 0 ? std::ldexp(share(random), -int(random() % 30)) : share(random));
  const std::size_t most = rgba.size() / 4;
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{2}, most - 1, most}) {
    std::vector<PackedVoxel> packed(most + 1, PackedVoxel{{7, 7}, {7, 7, 7}});
    pack(rgba.data(), count, packed.data());
    for (std::size_t k = 0; k < count; ++k) {
      const float* in = rgba.data() + 4 * k;
      const VoxelColour exact = unpack(packed[k]);
      const auto nearest = [](float value) { return int(value * 65535.0F + 0.5F); };
      CHECK((exact.red == nearest(in[0]) && exact.green == nearest(in[1]) && exact.blue == nearest(in[2])));
      CHECK(exact.opacity == in[3]);
    }
    // Nothing is written behind the last voxel.
    CHECK((packed[count].opacity[0] == 7 && packed[count].rgb[2] == 7));
  }
}
