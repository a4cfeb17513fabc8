#include <algorithm>
#include <numeric>

#include "frame/work_estimate.hpp"
#include "support/catch.hpp"

using namespace ringsplat;

namespace {

const TransferFunction above_half{
    "step", {{0, {1, 1, 1}}, {1, {1, 1, 1}}}, {{0, 0}, {0.5, 0}, {0.51, 1}, {1, 1}}, {1, 0, 0}};

/// A ball in a corner of the volume's box, or everywhere.
VolumeSketch sketch_of(const glm::ivec3& dims, const glm::dvec3& middle, double radius) {
  VolumeSketch sketch(dims);
  for (int z = 0; z < sketch.points.z; ++z)
    for (int y = 0; y < sketch.points.y; ++y)
      for (int x = 0; x < sketch.points.x; ++x) {
        const glm::dvec3 at(sketch.voxel(0, x), sketch.voxel(1, y), sketch.voxel(2, z));
        sketch.values[sketch.index({x, y, z})] = glm::length(at - middle) < radius ? 1.0F : 0.0F;
      }
  return sketch;
}

FrameSpec seen(Method how, double azimuth = 0, double elevation = 90) {
  FrameSpec spec;
  spec.how = how;
  spec.shown.camera.azimuth = azimuth;
  spec.shown.camera.elevation = elevation;
  spec.shown.transfer_function = above_half;
  return spec;
}

Grid grid_of(const glm::ivec3& dims) {
  Grid grid;
  grid.dims = dims;
  return grid;
}

/// Each Renderer's work, as geometry's owners share it.
std::vector<double> seconds_of_each(const FrameGeometry& g, const WorkEstimate& work, int renderers) {
  std::vector<double> seconds(std::size_t(renderers), 0.0);
  const std::vector<int> owners = g.owners(renderers);
  for (int region = 0; region < g.regions.count(); ++region)
    if (const int owner = owners[std::size_t(region)]; owner != nobody)
      seconds[std::size_t(owner)] += work.of(g.regions.rect(region)).seconds;
  return seconds;
}

/// The busiest Renderer's work against the mean.
double unevenness(const FrameGeometry& g, const WorkEstimate& work, int renderers) {
  const std::vector<double> seconds = seconds_of_each(g, work, renderers);
  const double sum = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  return *std::max_element(seconds.begin(), seconds.end()) * renderers / sum;
}

constexpr WorkCosts only_voxels{1e-8, 0, 0, 0, 0}, only_slices{0, 1e-9, 0, 0, 0};

/// A ball of voxels in a view, and what is estimated of its work.
struct Ball {
  Ball(const glm::ivec3& dims, const glm::dvec3& middle, double radius, FrameSpec seen,
       const WorkCosts& c = only_voxels)
      : spec(std::move(seen)),
        costs(c),
        sketch(sketch_of(dims, middle, radius)),
        g(make_geometry(spec, grid_of(dims))),
        work(g, sketch, points.of(sketch, spec.shown.transfer_function), costs, 1) {}
  void deal(FrameGeometry& to, const std::vector<double>& busy) const {
    deal_by_work(to, work, costs, spec, int(busy.size()), busy);
  }

  FrameSpec spec{.how = Splats{}};
  WorkCosts costs;
  VolumeSketch sketch;
  ShownPoints points;
  FrameGeometry g;
  WorkEstimate work;
};

}  // namespace

TEST_CASE("an estimate's parts add up to all visible voxels, wherever the plane is cut") {
  for (const double elevation : {90.0, 20.0}) {
    // Sheets cut nothing twice.
    const Ball ball({100, 90, 80}, {50, 45, 40}, 30, seen(Sheets{}, 30, elevation), only_slices);
    const double whole = ball.work.of({0, 0, ball.g.width, ball.g.height}).seconds;
    CHECK(whole > 0);
    double sum = 0;
    const Regions regions(ball.g.width, ball.g.height, 48);
    for (int region = 0; region < regions.count(); ++region)
      sum += ball.work.of(regions.rect(region)).seconds;
    CHECK(sum == Approx(whole));
  }
}

TEST_CASE("an estimate tells what a ball's voxels cost within a few percent") {
  const Grid grid = grid_of({128, 128, 128});
  const VolumeSketch sketch = sketch_of(grid.dims, {64, 64, 64}, 40);
  const FrameSpec spec = seen(Splats{});
  FrameGeometry g = make_geometry(spec, grid);
  g.reach = {0, 0};
  ShownPoints points;
  const WorkEstimate work(g, sketch, points.of(sketch, spec.shown.transfer_function), only_voxels, 1);
  const double voxels = 4.0 / 3 * 3.14159265 * 40 * 40 * 40;
  CHECK(work.of({0, 0, g.width, g.height}).seconds == Approx(1e-8 * voxels).epsilon(0.03));
}

TEST_CASE("regions dealt by work are shared more evenly than regions dealt in turn, on every rank alike") {
  for (const Method& how : {Method(Splats{}), Method(Sheets{})}) {
    const bool sheets = std::holds_alternative<Sheets>(how);
    for (const int renderers : {3, 8, 40}) {
      FrameSpec spec = seen(how);
      spec.division.dealt_to = renderers;
      const Ball ball(glm::ivec3(128), {30, 40, 64}, 28, spec, sheets ? only_slices : only_voxels);
      const FrameGeometry& in_turn = ball.g;
      FrameGeometry g = in_turn, again = in_turn;
      REQUIRE(ball.work.telling());
      ball.deal(g, std::vector<double>(std::size_t(renderers)));
      REQUIRE(!g.dealt.empty());
      ball.deal(again, std::vector<double>(std::size_t(renderers)));
      CHECK(g.dealt == again.dealt);
      CHECK(g.regions == again.regions);
      CAPTURE(renderers, sheets);
      CHECK(unevenness(g, ball.work, renderers) < 1.25);
      const double before = unevenness(in_turn, ball.work, renderers);
      CHECK(unevenness(g, ball.work, renderers) <= before);
      if (renderers == 40) CHECK(before > 1.5);
      // All that voxels can reach is somebody's, and nothing else.
      const PixelRect reached = reached_regions(g, g.regions);
      for (int region = 0; region < g.regions.count(); ++region) {
        const int x = region % g.regions.columns(), y = region / g.regions.columns();
        const bool inside = x >= reached.x0 && x < reached.x1 && y >= reached.y0 && y < reached.y1;
        CHECK((g.dealt[std::size_t(region)] != nobody) == inside);
      }
    }
  }
}

TEST_CASE("many Renderers' sheets of small blocks lie side by side, and most stay where they are in a turn") {
  const Grid grid = grid_of({512, 512, 512});
  const VolumeSketch sketch = sketch_of(grid.dims, {200, 280, 240}, 180);
  ShownPoints points;
  for (const int renderers : {5, 16, 64}) {
    CAPTURE(renderers);
    std::optional<WorkEstimate> estimate;
    const auto dealt = [&](double azimuth) {
      FrameSpec spec = seen(Sheets{}, azimuth, 20);
      spec.division.dealt_to = renderers;
      FrameGeometry g = make_geometry(spec, grid);
      REQUIRE(g.in_parts);
      const WorkCosts costs = costs_in(g, usual_sheet_costs);
      const auto shown = points.of(sketch, spec.shown.transfer_function, shown_blocks(g, costs));
      deal_by_work(g, estimate.emplace(g, sketch, shown, costs, 1), costs, spec, renderers,
                   std::vector<double>(std::size_t(renderers)));
      return g;
    };
    const FrameGeometry turned = dealt(32), first = dealt(30);
    // Of two neighbouring regions most have the same Renderer.
    int neighbours = 0, together = 0;
    for (int region = 0; region + first.regions.columns() < first.regions.count(); ++region) {
      const int here = first.dealt[std::size_t(region)],
                below = first.dealt[std::size_t(region + first.regions.columns())];
      if (here == nobody || below == nobody) continue;
      ++neighbours;
      together += here == below;
    }
    CHECK(together > 0.6 * neighbours);
    CHECK(unevenness(first, *estimate, renderers) < (renderers == 64 ? 1.6 : 1.25));
    double pixels = 0, stayed = 0;
    for (int y = 0; y < first.height; ++y)
      for (int x = 0; x < first.width; ++x) {
        const auto owner = [&](const FrameGeometry& g) {
          const PixelRect at = g.regions.touched({x, y, x, y});
          return g.dealt[std::size_t(at.y0 * g.regions.columns() + at.x0)];
        };
        if (owner(first) == nobody || owner(turned) == nobody) continue;
        ++pixels;
        stayed += owner(first) == owner(turned);
      }
    CHECK(stayed > 0.8 * pixels);
  }
}

TEST_CASE("the rank that puts the picture together is busy with it") {
  const Ball ball(glm::ivec3(128), glm::dvec3(64), 40, seen(Sheets{}));
  WorkCosts costs = only_voxels;
  const auto without = busy_ranks(ball.g, ball.work, costs, {4, 1}, 4, 2);
  costs.picture = 1e-6;
  const auto with = busy_ranks(ball.g, ball.work, costs, {4, 1}, 4, 2);
  CHECK(with[0] - without[0] == Approx(1e-6 * ball.g.width * ball.g.height));
  CHECK(with[1] == without[1]);
}

TEST_CASE("a size of regions that is asked for is kept, and a Renderer whose rank is busy gets less") {
  FrameSpec spec = seen(Splats{});
  spec.division = {32, 4};
  const Ball ball(glm::ivec3(128), glm::dvec3(64), 60, spec);
  const double all = ball.work.of({0, 0, ball.g.width, ball.g.height}).seconds;
  FrameGeometry g = ball.g;
  ball.deal(g, {all / 4, 0, 0, 0});
  CHECK(g.regions == Regions(512, 512, 32));
  const std::vector<double> seconds = seconds_of_each(g, ball.work, 4);
  CHECK(seconds[0] < 0.5 * seconds[1]);
}

TEST_CASE("a Renderer that was slower than foreseen gets less, in parts and otherwise") {
  for (const int renderers : {3, 8}) {
    FrameSpec spec = seen(Sheets{}, 30, 20);
    spec.division.dealt_to = renderers;
    spec.division.pace.assign(std::size_t(renderers), 1.0F);
    spec.division.pace[1] = 2;
    const Ball ball(glm::ivec3(256), {120, 130, 128}, 100, spec, only_slices);
    FrameGeometry g = ball.g;
    REQUIRE(g.in_parts == (renderers == 8));
    ball.deal(g, std::vector<double>(std::size_t(renderers)));
    const std::vector<double> seconds = seconds_of_each(g, ball.work, renderers);
    for (const int other : {0, 2}) {
      CHECK(seconds[1] < 0.7 * seconds[std::size_t(other)]);
      CHECK(seconds[1] > 0.3 * seconds[std::size_t(other)]);
    }
  }
}

TEST_CASE("with hardly a visible voxel, regions are dealt in turn") {
  const Ball ball(glm::ivec3(128), glm::dvec3(64), 3, seen(Splats{}));
  FrameGeometry g = ball.g;
  ball.deal(g, {0, 0, 0, 0});
  CHECK(g.dealt.empty());
}

TEST_CASE("points that were kept for an axis are those that are found anew") {
  const VolumeSketch sketch = sketch_of({100, 90, 80}, {50, 45, 40}, 30);
  const TransferFunction function = seen(Sheets{}).shown.transfer_function;
  const auto found = [&](ShownPoints& points, std::optional<ShownPoints::Blocks> blocks) {
    const auto shown = points.of(sketch, function, blocks);
    return std::vector<std::uint32_t>(shown.begin(), shown.end());
  };
  ShownPoints kept;
  for (const double side : {8.0, 24.0, 8.0})
    for (const Axis axis : {Axis::x, Axis::z, Axis::x, Axis::y, Axis::z}) {
      ShownPoints anew;
      const ShownPoints::Blocks blocks{axis, side};
      CHECK(found(kept, blocks) == found(anew, blocks));
    }
  ShownPoints anew;
  CHECK(found(kept, std::nullopt) == found(anew, std::nullopt));
}
