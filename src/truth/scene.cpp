#include "truth/scene.hpp"

#include <algorithm>

#include "volume/scalars.hpp"

namespace ringsplat::truth {

Scene cropped(const Scene& scene) {
  check(*scene.frame.shown.clip, scene.grid);
  const glm::ivec3 first = scene.frame.shown.clip->first, end = scene.frame.shown.clip->end,
                   dims = scene.grid.dims;
  Scene part = scene;
  part.frame.shown.clip.reset();
  part.cut_from = {{dims, scene.grid.spacing, scene.grid.origin, scene.grid.direction}, first};
  part.grid.dims = end - first;
  part.grid.origin = scene.grid.origin + scene.grid.direction * (scene.grid.spacing * glm::dvec3(first));
  part.values.clear();
  for (int z = first.z; z < end.z; ++z)
    for (int y = first.y; y < end.y; ++y) {
      const auto row = scene.values.begin() + (std::ptrdiff_t(z) * dims.y + y) * dims.x;
      part.values.insert(part.values.end(), row + first.x, row + end.x);
    }
  return part;
}

std::vector<double> read_values(VolumeSource& source) {
  const Grid& grid = source.grid();
  const std::size_t slice = grid.slice_voxels(Axis::z);
  std::vector<double> values(std::size_t(grid.voxels()));
  std::vector<std::byte> bytes(grid.slice_bytes(Axis::z));
  for (int z = 0; z < grid.dims.z; ++z) {
    source.read_slices(z, 1, bytes);
    for_values(grid.type, bytes, [&](auto some) {
      std::copy(some.begin(), some.end(), values.begin() + std::ptrdiff_t(std::size_t(z) * slice));
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

Image to_image(int width, int height, std::span<const Rgba> colours) {
  Image image(width, height);
  for (std::size_t p = 0; p < colours.size(); ++p)
    for (int c = 0; c < 4; ++c) image.rgba[4 * p + std::size_t(c)] = static_cast<float>(colours[p][c]);
  return image;
}

}  // namespace ringsplat::truth
