#include <algorithm>

#include "forecast/forecast.hpp"
#include "scene/scene.hpp"
#include "volume/value_statistics.hpp"

namespace ringsplat::app {
namespace {

constexpr std::int64_t most_voxels = std::int64_t{1} << 24;
constexpr int sections_of_large_volumes = 3;

using Section = std::vector<std::byte>;

std::vector<Section> read_sections(VolumeSource& source) {
  const Grid& grid = source.grid();
  const auto read = [&](int first, int slices) {
    Section section(grid.slice_bytes(Axis::z) * std::size_t(slices));
    source.read_slices(first, slices, section);
    return section;
  };
  if (grid.voxels() <= most_voxels) return {read(0, grid.dims.z)};
  const auto in_slice = std::int64_t(grid.slice_voxels(Axis::z));
  const int wanted = int(std::max<std::int64_t>(1, most_voxels / sections_of_large_volumes / in_slice));
  const int thick = std::min(wanted, std::max(1, grid.dims.z / sections_of_large_volumes));
  const int count = std::min(sections_of_large_volumes, grid.dims.z);
  std::vector<Section> sections;
  for (int k = 0; k < count; ++k) {
    const int middle = int((2 * std::int64_t(k) + 1) * grid.dims.z / (2 * count));
    sections.push_back(read(std::clamp(middle - thick / 2, 0, grid.dims.z - thick), thick));
  }
  return sections;
}

}  // namespace

TransferFunction function_for(VolumeSource& source, const TransferFunctionChoice& choice) {
  const Grid& grid = source.grid();
  const VolumeNotes notes = source.notes();
  const std::vector<Section> sections = read_sections(source);
  const Pass pass = [&](const RowVisitor& visit) {
    for (const Section& section : sections) visit(section, grid.dims.x);
  };
  Merging alone;
  return choice.make(describe_values({grid.type, notes.fill}, grid.dims, notes, pass, alone)).function;
}

VolumeSketch sketch_of(VolumeSource& source) {
  const Grid& grid = source.grid();
  VolumeSketch sketch(grid.dims);
  std::vector<std::byte> slice(grid.slice_bytes(Axis::z));
  for (int z = 0; z < sketch.points.z; ++z) {
    source.read_slices(sketch.voxel(2, z), 1, slice);
    const auto points = points_of(sketch, {.axis = Axis::z,
                                           .width = grid.dims.x,
                                           .height = grid.dims.y,
                                           .type = grid.type,
                                           .values = slice.data()});
    std::copy(points.begin(), points.end(), sketch.values.begin() + std::ptrdiff_t(sketch.index({0, 0, z})));
  }
  return sketch;
}

std::vector<Camera> some_views(const std::vector<Camera>& cameras) {
  if (cameras.size() < 12) return {cameras.front()};
  return {cameras.front(), cameras[cameras.size() / 3], cameras[2 * cameras.size() / 3]};
}

}  // namespace ringsplat::app
