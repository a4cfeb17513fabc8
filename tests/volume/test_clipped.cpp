#include "volume/clipped.hpp"

#include <cstring>
#include <vector>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/message_of.hpp"
#include "volume/slice_store.hpp"

using namespace ringsplat;

namespace {

/// 5 x 4 x 3 voxels whose values tell where they are.
struct Numbered {
  Grid grid;
  std::vector<std::uint16_t> values;
  Numbered() {
    grid.dims = {5, 4, 3};
    grid.spacing = {0.5, 2, 3};
    grid.origin = {7, -3, 1};
    grid.direction = glm::dmat3(glm::dvec3(0, 1, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 0, 1));
    grid.type = ScalarType::uint16;
    for (int z = 0; z < 3; ++z)
      for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 5; ++x) values.push_back(std::uint16_t(100 * z + 10 * y + x));
  }
  std::unique_ptr<VolumeSource> source() const {
    return memory_source(grid, std::as_bytes(std::span(values)));
  }
};

}  // namespace

TEST_CASE("a clipped source has the box's voxels at their places") {
  const Numbered whole;
  const auto source = whole.source();
  const VoxelBox box{{1, 2, 1}, {4, 4, 3}};
  const auto part = clipped_source(*source, box);
  CHECK(part->grid().dims == glm::ivec3(3, 2, 2));
  CHECK(part->grid().spacing == whole.grid.spacing);
  CHECK(part->grid().origin == glm::dvec3(7 - 4, -3 + 0.5, 1 + 3));
  std::vector<std::uint16_t> values(12);
  part->read_slices(0, 2, std::as_writable_bytes(std::span(values)));
  CHECK(values == std::vector<std::uint16_t>{121, 122, 123, 131, 132, 133, 221, 222, 223, 231, 232, 233});
  std::vector<std::uint16_t> last(6);
  part->read_slices(1, 1, std::as_writable_bytes(std::span(last)));
  CHECK(last == std::vector<std::uint16_t>{221, 222, 223, 231, 232, 233});
  CHECK_THROWS_AS(clipped_source(*source, {{0, 0, 0}, {6, 4, 3}}), InputError);
}

TEST_CASE("a box outside of the volume or without voxels is refused, and its axis is named") {
  Grid grid;
  grid.dims = {5, 4, 3};
  const auto refusal = [&](const VoxelBox& box) { return message_of([&] { check(box, grid); }); };
  CHECK(refusal(whole_box(grid)).empty());
  CHECK(refusal({{4, 3, 2}, {5, 4, 3}}).empty());
  CHECK(says(refusal({{-1, 0, 0}, {5, 4, 3}}), "x part, -1:5, does not lie within the volume's 0:5"));
  CHECK(says(refusal({{0, 1, 0}, {5, 5, 3}}), "y part, 1:5, does not lie within the volume's 0:4"));
  CHECK(says(refusal({{0, 0, 2}, {5, 4, 2}}), "z part, 2:2, has no voxel"));
  CHECK(says(refusal({{3, 0, 0}, {2, 4, 3}}), "x part, 3:2, has no voxel"));
}

TEST_CASE("a slice of a box is the part in the box of the volume's slice, along each axis") {
  const Numbered whole;
  SliceStore store(whole.grid, 0, 1, {true, true, true}, true);
  for (const Axis axis : all_axes) {
    const auto [u, v] = in_plane(axis);
    const int k = static_cast<int>(axis);
    for (int s = 0; s < whole.grid.dims[k]; ++s) {
      auto values = store.values(axis, s);
      auto normals = store.normals(axis, s);
      for (int j = 0; j < whole.grid.dims[v]; ++j)
        for (int i = 0; i < whole.grid.dims[u]; ++i) {
          glm::ivec3 p;
          p[u] = i, p[v] = j, p[k] = s;
          const auto value = std::uint16_t(100 * p.z + 10 * p.y + p.x);
          const std::size_t at = std::size_t(j * whole.grid.dims[u] + i);
          std::memcpy(values.data() + 2 * at, &value, 2);
          normals[at] = std::uint16_t(value + 1000);
        }
    }
    const VoxelBox box{{1, 1, 1}, {4, 3, 3}};
    const SliceView slice = store.slice(axis, 1, box);
    CHECK(slice.index == 1);
    REQUIRE(slice.width == box.dims()[u]);
    REQUIRE(slice.height == box.dims()[v]);
    for (int j = 0; j < slice.height; ++j)
      for (int i = 0; i < slice.width; ++i) {
        glm::ivec3 p;
        p[u] = 1 + i, p[v] = 1 + j, p[k] = 2;
        std::uint16_t value;
        std::memcpy(&value, slice.values_of_row(j) + 2 * i, 2);
        CHECK(value == 100 * p.z + 10 * p.y + p.x);
        CHECK(slice.normals_of_row(j)[i] == value + 1000);
      }
  }
}
