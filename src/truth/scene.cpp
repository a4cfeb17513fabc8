#include "ringsplat/truth/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <unordered_set>

#include "ringsplat/base/error.hpp"

namespace ringsplat::truth {

void check(const Scene& scene) {
  check(scene.grid, "the reference's volume");
  check(scene.transfer_function, scene.transfer_function.name);
  if (scene.values.size() != std::size_t(scene.grid.voxels()))
    throw InputError(
        fmt::format("the reference has {} values for {} voxels", scene.values.size(), scene.grid.voxels()),
        "read the whole volume");
}

std::vector<double> read_values(VolumeSource& source) {
  const Grid& grid = source.grid();
  const std::size_t slice = grid.slice_voxels(Axis::z);
  std::vector<double> values(std::size_t(grid.voxels()));
  std::vector<std::byte> bytes(grid.slice_bytes(Axis::z));
  for (int z = 0; z < grid.dims.z; ++z) {
    source.read_slices(z, 1, bytes);
    visit_type(grid.type, [&](auto zero) {
      using T = decltype(zero);
      for (std::size_t i = 0; i < slice; ++i) {
        T v;
        std::memcpy(&v, bytes.data() + i * sizeof(T), sizeof(T));
        values[std::size_t(z) * slice + i] = static_cast<double>(v);
      }
    });
  }
  return values;
}

std::vector<Pixel> all_pixels(int width, int height) {
  std::vector<Pixel> pixels;
  pixels.reserve(std::size_t(width) * std::size_t(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) pixels.push_back({x, y});
  return pixels;
}

std::vector<Pixel> random_pixels(int width, int height, std::size_t count, std::uint64_t seed) {
  const std::uint64_t total = std::uint64_t(width) * std::uint64_t(height);
  if (count >= total) return all_pixels(width, height);
  // Floyd's sampling without replacement (Bentley and Floyd 1987). The standard fixes the engine's numbers
  // but not its distributions', so the remainder is taken here; its bias is below 2^-30 for any picture.
  std::mt19937_64 random(seed);
  std::unordered_set<std::uint64_t> chosen;
  for (std::uint64_t j = total - count; j < total; ++j)
    if (!chosen.insert(random() % (j + 1)).second) chosen.insert(j);
  std::vector<std::uint64_t> places(chosen.begin(), chosen.end());
  std::sort(places.begin(), places.end());
  std::vector<Pixel> pixels;
  for (const std::uint64_t p : places)
    pixels.push_back({int(p % std::uint64_t(width)), int(p / std::uint64_t(width))});
  return pixels;
}

Image to_image(int width, int height, std::span<const Rgba> colours) {
  Image image(width, height);
  for (std::size_t p = 0; p < colours.size(); ++p)
    for (int c = 0; c < 4; ++c) image.rgba[4 * p + std::size_t(c)] = static_cast<float>(colours[p][c]);
  return image;
}

}  // namespace ringsplat::truth
