#include "splat/aligned_slice.hpp"

#include <cstring>
#include <random>
#include <set>

#include "splat/run_sum.hpp"
#include "splat/scene.hpp"
#include "splat/voxel_sum.hpp"
#include "support/catch.hpp"
#include "support/vector_targets.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr int width = 45, height = 38, left_x = 20, top_y = -7;
constexpr int slice = 3;

/// Slices sheared by fractions of a pixel.
ViewTransform aligned_view(double step_x, double step_y) {
  ViewTransform view;
  view.linear = glm::dmat3(0.0);
  view.linear[0] = {step_x, 0, 0.3};
  view.linear[1] = {0, step_y, 0.1};
  view.linear[2] = {0.40625, -0.28125, 1};
  view.offset = {11.5, -13.25, 0};
  return view;
}

struct Row {
  std::uint32_t row, first;
  std::vector<VoxelColour> voxels;
};

/// Runs before, behind, across and inside the region, row by row; no voxel twice.
std::vector<Row> random_runs(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<std::uint32_t> rows(1, 3), gap(1, 20), count(1, 64), colour(0, 65535);
  std::uniform_real_distribution<float> opacity(0, 1);
  std::vector<Row> runs;
  for (std::uint32_t row = 0; row <= 50; row += rows(random)) {
    for (std::uint32_t first = gap(random) - 1; first < 60;) {
      Row run{row, first, {}};
      for (std::uint32_t n = count(random); n > 0; --n)
        run.voxels.push_back({std::uint16_t(colour(random)), std::uint16_t(colour(random)),
                              std::uint16_t(colour(random)), opacity(random)});
      first += std::uint32_t(run.voxels.size()) + gap(random);
      runs.push_back(run);
    }
  }
  return runs;
}

struct Painted {
  std::vector<float> tile;
  DrawCounts counts;
};

AlignedFrame aligned_frame(const Footprint& footprint, const ViewTransform& view) {
  const auto frame = AlignedFrame::of(footprint, view, Axis::z);
  REQUIRE(frame);
  return *frame;
}

void add(DrawCounts& sum, const DrawCounts& counts) {
  sum.drawn += counts.drawn;
  sum.clipped += counts.clipped;
}

PackedVoxel packed(const VoxelColour& voxel) {
  PackedVoxel to{{}, {voxel.red, voxel.green, voxel.blue}};
  std::memcpy(to.opacity, &voxel.opacity, sizeof to.opacity);
  return to;
}

/// The runs' voxels by row and 64 columns, as payloads have them.
struct Block {
  VoxelRun where;
  std::vector<PackedVoxel> voxels;
};
std::vector<Block> to_blocks(const std::vector<Row>& runs) {
  std::vector<Block> blocks;
  for (const Row& run : runs) {
    for (std::size_t k = 0; k < run.voxels.size(); ++k) {
      const std::uint32_t column = run.first + std::uint32_t(k), first = column / 64 * 64;
      if (blocks.empty() || blocks.back().where.row != run.row || blocks.back().where.first != first)
        blocks.push_back({{run.row, first, 0}, {}});
      blocks.back().where.mask |= std::uint64_t{1} << column % 64;
      blocks.back().voxels.push_back(packed(run.voxels[k]));
    }
  }
  return blocks;
}

/// Through a VoxelSum or a RunSum.
template <class Sum>
Painted paint(Sum sum, const std::vector<Row>& runs) {
  RegionImage image({left_x, top_y, left_x + width, top_y + height});
  sum.begin(image, slice);
  DrawCounts counts;
  for (const Block& block : to_blocks(runs)) {
    const auto* where = reinterpret_cast<const std::byte*>(&block.where);
    add(counts, sum.draw(VoxelRuns{where, 1, block.voxels.data()}, 1).counts);
  }
  sum.composite();
  return {tile_of(image, width, height), counts};
}

constexpr PixelRect largest{0, 0, width + 9, height + 5};

Painted paint_rows(const Footprint& footprint, const ViewTransform& view, const std::vector<Row>& runs) {
  return paint(VoxelSum(aligned_frame(footprint, view), largest), runs);
}

Painted paint_splats(const Footprint& footprint, const ViewTransform& view, const std::vector<Row>& runs) {
  return paint(RunSum(footprint, SliceDda(view, Axis::z, 192), largest), runs);
}

}  // namespace

TEST_CASE("rows of voxels draw the bits of their splats, on every instruction set") {
  for (const auto& [step_x, step_y] : {std::pair{1.0, 1.0}, {2.0, 2.0}, {4.0, 4.0}, {1.0, 2.0}, {4.0, 1.0}}) {
    for (const double radius : {0.5, 1.0, 1.1, 1.6, 2.4, 5.0}) {
      const ViewTransform view = aligned_view(step_x, step_y);
      const Footprint footprint = make_footprint(view, Axis::z, radius);
      const auto runs = random_runs(unsigned(10 * radius));
      const Painted splats = paint_splats(footprint, view, runs);
      REQUIRE(*std::max_element(splats.tile.begin(), splats.tile.end()) > 0.1F);
      for (const auto& target : vector_targets()) {
        use_vector_target(target);
        INFO(target << ", " << step_x << " x " << step_y << " pixels a voxel, radius " << radius);
        const Painted rows = paint_rows(footprint, view, runs);
        CHECK(same_bits(rows.tile, splats.tile));
        CHECK(rows.counts.drawn == splats.counts.drawn);
        CHECK(rows.counts.clipped == splats.counts.clipped);
      }
      use_vector_target("");
    }
  }
}

/// How many voxels of a row reach a pixel goes by where between the pixels they lie.
TEST_CASE("rows of voxels draw the bits of their splats wherever between the pixels they lie") {
  std::set<int> taps;
  for (const double step : {1.0, 2.0}) {
    for (const double radius : {0.5, 1.0, 1.1, 1.6}) {
      for (const double place : {0.0, 0.05, 0.3, 0.5, 0.95}) {
        ViewTransform view = aligned_view(step, step);
        view.linear[2] = {0, 0, 1};
        view.offset = {11.5 + place, -13.5 + place, 0};
        const auto runs = random_runs(unsigned(100 * (radius + place)));
        const Footprint footprint = make_footprint(view, Axis::z, radius);
        INFO(step << " pixels a voxel, radius " << radius << ", " << place << " behind a pixel");
        CHECK(same_bits(paint_rows(footprint, view, runs).tile, paint_splats(footprint, view, runs).tile));
        taps.insert(aligned_frame(footprint, view).slice(slice).taps);
      }
    }
  }
  CHECK(taps == std::set{1, 2, 3, 4});
}

TEST_CASE("only voxels that lie a whole number of pixels apart make an aligned slice") {
  const auto aligned = [](const ViewTransform& view, double radius = 1.6) {
    return AlignedFrame::of(make_footprint(view, Axis::z, radius), view, Axis::z).has_value();
  };
  CHECK(aligned(aligned_view(1, 1)));
  CHECK_FALSE(aligned(aligned_view(1.5, 1)));
  CHECK_FALSE(aligned(aligned_view(1, 3)));
  CHECK_FALSE(aligned(view_of({1.0, 0.1})));
  CHECK_FALSE(aligned(aligned_view(4, 4), 8));
}

TEST_CASE("a voxel without a plausible opacity adds nothing to a row") {
  const ViewTransform view = aligned_view(1, 1);
  const Footprint footprint = make_footprint(view, Axis::z, 1.6);
  Row run{20, 12, std::vector<VoxelColour>(9, {65535, 30000, 100, 0.5F})};
  run.voxels[4].opacity = 0;
  const Painted without = paint_rows(footprint, view, {run});
  for (const float opacity :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1e30F}) {
    run.voxels[4].opacity = opacity;
    CHECK(same_bits(paint_rows(footprint, view, {run}).tile, without.tile));
  }
}

TEST_CASE("rows of voxels go from region to region") {
  const ViewTransform view = aligned_view(2, 1);
  const Footprint footprint = make_footprint(view, Axis::z, 1.6);
  const VoxelColour voxel{65535, 30000, 100, 0.5F};
  const auto dense = to_blocks({{20, 0, std::vector<VoxelColour>(40, voxel)}}),
             sparse = to_blocks({{20, 12, {voxel}}});
  constexpr PixelRect first{left_x, top_y, left_x + width, top_y + height},
      second{left_x, top_y - 3, left_x + width + 9, top_y + 70};
  const auto draw = [](VoxelSum& sum, RegionImage& image, const std::vector<Block>& blocks) {
    sum.begin(image, slice);
    for (const Block& block : blocks) {
      const auto* where = reinterpret_cast<const std::byte*>(&block.where);
      sum.draw(VoxelRuns{where, 1, block.voxels.data()}, 1);
    }
  };
  const auto paint_second = [&](bool after_first) {
    VoxelSum sum(aligned_frame(footprint, view), second);
    RegionImage image(first), other(second);
    if (after_first) {
      draw(sum, image, dense);
      sum.composite();
    }
    draw(sum, other, sparse);
    sum.composite();
    return tile_of(other, second.width(), second.height());
  };
  const auto alone = paint_second(false);
  CHECK(*std::max_element(alone.begin(), alone.end()) > 0.1F);
  CHECK(same_bits(paint_second(true), alone));
}

TEST_CASE("voxels that reach no pixel of a region leave it untouched, and its slice buffer empty") {
  const ViewTransform view = aligned_view(1, 1);
  const Footprint footprint = make_footprint(view, Axis::z, 1.6);
  VoxelSum sum(aligned_frame(footprint, view), {0, 0, width, height});
  // A kernel's corner weights are 0: the voxel whose window's corner alone is in the region does not reach
  // it.
  const AlignedSlice aligned = aligned_frame(footprint, view).slice(slice);
  const auto voxels = to_blocks({{20, 12, {{65535, 30000, 100, 0.5F}}}});
  const auto x = int(aligned.anchor_x) + 12 + aligned.reach_x + 1,
             y = int(aligned.anchor_y) + 20 + aligned.reach_y + 1;
  RegionImage corner({x, y, x + width, y + height});
  sum.begin(corner, slice);
  const auto* where = reinterpret_cast<const std::byte*>(&voxels[0].where);
  CHECK(sum.draw(VoxelRuns{where, 1, voxels[0].voxels.data()}, 1).counts.clipped == 1);
  sum.composite();
  CHECK_FALSE(corner.touched());
  sum.begin(corner, slice);
  sum.composite();
  CHECK_FALSE(corner.touched());
}
