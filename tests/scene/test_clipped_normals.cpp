// Normals of a clipped volume: those of the cropped one within the box, none beyond it.
#include <glm/vector_relational.hpp>
#include <random>

#include "classify/normals.hpp"
#include "scene/scene.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/scenes.hpp"
#include "support/thread_collectives.hpp"
#include "volume/clipped.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// By slice and axis, the normals that so many processes with a GP each make.
std::array<std::vector<std::vector<std::uint16_t>>, 3> normals_of(const Grid& grid,
                                                                  std::span<const std::byte> voxels,
                                                                  const std::optional<VoxelBox>& clip,
                                                                  bool crop, int processes) {
  std::array<std::vector<std::vector<std::uint16_t>>, 3> found;
  const Grid shown = crop ? clipped_grid(grid, *clip) : grid;
  for (const Axis axis : all_axes) found[std::size_t(axis)].resize(std::size_t(shown.slices(axis)));
  std::vector<int> process_of_gp;
  for (int p = 0; p < processes; ++p) process_of_gp.push_back(p);
  LoadOptions options;
  options.with_normals = true;
  if (!crop) options.clip = clip;
  const auto thrown = run_as_processes(processes, [&](ThreadCollectives& collectives) {
    const auto whole = memory_source(grid, voxels);
    OpenedVolume volume = open_everywhere(collectives, [&]() -> std::unique_ptr<VolumeSource> {
      if (crop) return clipped_source(*whole, *clip);
      return memory_source(grid, voxels);
    });
    auto stores = deal_slices(volume, options, {processes, process_of_gp, collectives});
    for (auto& [gp, store] : stores)
      for (const Axis axis : all_axes)
        for (int s = 0; s < shown.slices(axis); ++s) {
          if (!store.owns(s)) continue;
          const auto normals = store.normals(axis, s);
          found[std::size_t(axis)][std::size_t(s)].assign(normals.begin(), normals.end());
        }
  });
  REQUIRE(thrown == std::vector<std::string>(std::size_t(processes)));
  return found;
}

}  // namespace

TEST_CASE("within a clip box normals are those of the cropped volume, and beyond it there are none") {
  Grid grid = make_grid({11, 10, 9});
  std::mt19937 random(7);
  std::vector<std::uint8_t> voxels(990);
  for (auto& voxel : voxels) voxel = std::uint8_t(random() % 256);
  const auto bytes = std::as_bytes(std::span(voxels));
  for (const VoxelBox& box :
       {VoxelBox{{3, 2, 4}, {8, 9, 7}}, {{0, 1, 0}, {11, 10, 3}}, {{5, 5, 5}, {6, 6, 6}}})
    for (const int processes : {1, 3}) {
      const auto clipped = normals_of(grid, bytes, box, false, processes),
                 cropped = normals_of(grid, bytes, box, true, processes);
      for (const Axis axis : all_axes) {
        const auto [u, v] = in_plane(axis);
        const int k = int(axis);
        glm::ivec3 at;
        for (at[k] = 0; at[k] < grid.dims[k]; ++at[k])
          for (at[v] = 0; at[v] < grid.dims[v]; ++at[v])
            for (at[u] = 0; at[u] < grid.dims[u]; ++at[u]) {
              const glm::ivec3 p = at - box.first, dims = box.dims();
              const bool inside =
                  glm::all(glm::greaterThanEqual(p, glm::ivec3(0))) && glm::all(glm::lessThan(p, dims));
              const auto& slice = clipped[std::size_t(k)][std::size_t(at[k])];
              const std::uint16_t here = slice[std::size_t(at[v] * grid.dims[u] + at[u])];
              INFO(name(axis) << ' ' << at.x << ' ' << at.y << ' ' << at.z << ", " << processes);
              if (!inside)
                REQUIRE(here == no_normal);
              else
                REQUIRE(here ==
                        cropped[std::size_t(k)][std::size_t(p[k])][std::size_t(p[v] * dims[u] + p[u])]);
            }
      }
    }
}
