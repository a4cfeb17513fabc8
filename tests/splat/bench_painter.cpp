// Splats per second that one core draws, and what composition costs: a ball of voxels as large as the visible
// part of a 128³ head, as payloads of slices for regions of 128 pixels. Prints the best of several frames.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

#include "base/byte_stream.hpp"
#include "base/process.hpp"
#include "ringsplat/base/bytes.hpp"
#include "splat/region_painter.hpp"
#include "splat/splat.hpp"
#include "splat/splat_sum.hpp"
#include "support/vector_targets.hpp"

using namespace ringsplat;

namespace {

using Clock = std::chrono::steady_clock;
constexpr int region_size = 128;

struct Scene {
  Footprint footprint;
  int size, columns;
  std::vector<std::vector<Bytes>> slices;  ///< [slice][region]
  std::size_t splats = 0;
};

ViewTransform make_scaled_view(double scale, int size, double degrees) {
  ViewTransform view;
  const double c = std::cos(degrees * 0.017453292519943295), s = std::sin(degrees * 0.017453292519943295);
  view.linear = glm::dmat3(scale * c, scale * s, 0, -scale * s, scale * c, 0, 0, 0, scale);
  const auto middle = view.linear * glm::dvec3(63.5, 63.5, 0);
  view.offset = {0.5 * size - middle.x, 0.5 * size - middle.y, 0};
  return view;
}

/// A shell of voxels with about 32 % of the 128³ lattice.
bool visible(int x, int y, int z) {
  const double r2 = (x - 63.5) * (x - 63.5) + (y - 63.5) * (y - 63.5) + (z - 63.5) * (z - 63.5);
  return r2 < 58.0 * 58.0 && r2 > 34.0 * 34.0;
}

void add_splat(Scene& scene, std::vector<Bytes>& slice, const glm::dvec3& at) {
  const auto anchored = anchor(at.x, at.y);
  const auto window = pixel_window(anchored, kernel_reach(scene.footprint));
  for (auto ry = std::max<std::int64_t>(0, window.y0 / region_size);
       ry <= window.y1 / region_size && ry < scene.columns; ++ry) {
    for (auto rx = std::max<std::int64_t>(0, window.x0 / region_size);
         rx <= window.x1 / region_size && rx < scene.columns; ++rx) {
      const auto base_x = rx * region_size - 64, base_y = ry * region_size - 64;
      append(slice[static_cast<std::size_t>(ry * scene.columns + rx)],
             make_splat(scene.footprint, anchored.dx, anchored.dy, 0.7F, 0.5F, 0.4F, 0.05F,
                        static_cast<std::uint8_t>(anchored.anchor_x - base_x),
                        static_cast<std::uint8_t>(anchored.anchor_y - base_y)));
      ++scene.splats;
    }
  }
}

Scene make_scene(int size, double degrees) {
  Scene scene;
  const auto view = make_scaled_view(1.17 * size / 256.0, size, degrees);
  scene.footprint = make_footprint(view, Axis::z, 1.6);
  scene.size = size;
  scene.columns = size / region_size;
  for (int z = 0; z < 128; ++z) {
    std::vector<Bytes> slice(static_cast<std::size_t>(scene.columns * scene.columns));
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 128; ++x) {
        if (visible(x, y, z)) add_splat(scene, slice, view.project({x, y, z}));
      }
    }
    scene.slices.push_back(std::move(slice));
  }
  return scene;
}

void measure(int size, double degrees) {
  const auto scene = make_scene(size, degrees);
  SliceBufferMemory memory;
  std::vector<RegionImage> images;
  for (int y = 0; y < scene.columns; ++y) {
    for (int x = 0; x < scene.columns; ++x)
      images.emplace_back(
          PixelRect{x * region_size, y * region_size, (x + 1) * region_size, (y + 1) * region_size});
  }
  double best_draw = 1e9, best_composite = 1e9, best = 1e9;
  for (int frame = 0; frame < 15; ++frame) {
    double draw = 0, composite = 0;
    for (RegionImage& image : images) image.begin_frame(0);
    SplatSum sum(test::plain_kernel(scene.footprint), {region_size, region_size}, memory);
    for (const auto& slice : scene.slices) {
      for (std::size_t r = 0; r < images.size(); ++r) {
        const auto start = Clock::now();
        sum.begin(images[r]);
        sum.draw(images[r].rect().x0 - 64, images[r].rect().y0 - 64, slice[r]);
        const auto drawn = Clock::now();
        sum.composite(glm::dvec2(0.0));
        draw += std::chrono::duration<double>(drawn - start).count();
        composite += std::chrono::duration<double>(Clock::now() - drawn).count();
      }
    }
    best_draw = std::min(best_draw, draw);
    best_composite = std::min(best_composite, composite);
    best = std::min(best, draw + composite);
  }
  const auto splats = static_cast<double>(scene.splats);
  const auto reach = kernel_reach(scene.footprint);
  std::printf(
      "%-6s %5d px %4.0f deg window %2dx%-2d  %7.0f splats  draw %7.2f ms %6.1f M/s  composite %6.2f ms  "
      "frame %7.2f ms %6.1f M/s\n",
      vector_target(), size, degrees, static_cast<int>(2 * reach.x + 2), static_cast<int>(2 * reach.y + 2),
      splats, best_draw * 1e3, splats / best_draw * 1e-6, best_composite * 1e3, best * 1e3,
      splats / best * 1e-6);
}

void measure_encoding() {
  const auto footprint = make_footprint(make_scaled_view(1.17, 256, 7), Axis::z, 1.6);
  std::vector<Splat> out(1 << 14);
  double best = 1e9;
  for (int repeat = 0; repeat < 200; ++repeat) {
    const auto start = Clock::now();
    double x = 3.3 + repeat, y = 8.1;
    for (auto& splat : out) {
      const auto at = anchor(x, y);
      splat = make_splat(footprint, at.dx, at.dy, 0.7F, 0.5F, 0.4F, 0.05F,
                         static_cast<std::uint8_t>(at.anchor_x), static_cast<std::uint8_t>(at.anchor_y));
      x += 1.16, y += 0.14;
    }
    best = std::min(best, std::chrono::duration<double>(Clock::now() - start).count());
  }
  float checksum = 0;  // printed, so that the loop above is not optimised away
  for (const auto& splat : out) checksum += splat.a;
  std::printf("encode %.1f M splats/s (checksum %g)\n", static_cast<double>(out.size()) / best * 1e-6,
              static_cast<double>(checksum));
}

}  // namespace

int main(int argc, char** argv) {
  flush_denormals();
  measure_encoding();
  for (const auto& target : vector_targets()) {
    if (argc > 1 && target != argv[1]) continue;
    use_vector_target(target);
    for (const int size : {256, 512, 1024}) {
      for (const double degrees : {0.0, 20.0}) measure(size, degrees);
    }
  }
}
