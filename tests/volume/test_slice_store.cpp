#include <cstring>
#include <stdexcept>

#include "support/catch.hpp"
#include "volume/slice_store.hpp"

using namespace ringsplat;

namespace {

constexpr std::array<bool, 3> all_kept{true, true, true};

template <class T>
T value_at(int x, int y, int z) {
  return T(x * 7 + y * 31 + z * 101 + 3);
}

std::uint16_t normal_at(int x, int y, int z) { return std::uint16_t(x * 1009 + y * 131 + z * 17 + 1); }

struct ZSlice {
  std::vector<std::byte> values;
  std::vector<std::uint16_t> normals;
};

ZSlice z_slice(const Grid& grid, int z, bool with_normals) {
  ZSlice slice;
  slice.values.resize(grid.slice_bytes(Axis::z));
  visit_type(grid.type, [&](auto type) {
    using T = decltype(type);
    auto* out = reinterpret_cast<T*>(slice.values.data());
    for (int y = 0; y < grid.dims.y; ++y)
      for (int x = 0; x < grid.dims.x; ++x) *out++ = value_at<T>(x, y, z);
  });
  if (with_normals)
    for (int y = 0; y < grid.dims.y; ++y)
      for (int x = 0; x < grid.dims.x; ++x) slice.normals.push_back(normal_at(x, y, z));
  return slice;
}

/// Deals every z slice to all GPs, as loading does, then counts the wrong voxels.
int wrong_voxels(const Grid& grid, SliceDealing dealing, bool with_normals) {
  std::vector<SliceStore> stores;
  for (int g = 0; g < dealing.gps; ++g) stores.emplace_back(grid, g, dealing, all_kept, with_normals);
  int wrong = 0;
  for (int z = 0; z < grid.dims.z; ++z) {
    const auto slice = z_slice(grid, z, with_normals);
    for (int g = 0; g < dealing.gps; ++g)
      for (const Axis axis : {Axis::x, Axis::y}) {
        std::vector<std::byte> bytes;
        pack_columns(grid, axis, g, dealing, slice.values, slice.normals, bytes);
        stores[std::size_t(g)].unpack_columns(axis, z, bytes);
      }
  }
  for (const Axis axis : {Axis::x, Axis::y})
    for (int s = 0; s < grid.slices(axis); ++s) {
      const auto view = stores[std::size_t(dealing.owner_of(s))].slice(axis, s);
      visit_type(grid.type, [&](auto type) {
        using T = decltype(type);
        const auto* values = reinterpret_cast<const T*>(view.values);
        for (int v = 0; v < view.height; ++v)
          for (int u = 0; u < view.width; ++u) {
            const int x = axis == Axis::x ? s : u, y = axis == Axis::x ? u : s;
            wrong += values[v * view.width + u] != value_at<T>(x, y, v);
            if (with_normals) wrong += view.normals[v * view.width + u] != normal_at(x, y, v);
          }
      });
    }
  return wrong;
}

}  // namespace

TEST_CASE("columns packed from z slices arrive in their x and y slices", "[slice_store]") {
  const auto dims =
      GENERATE(glm::ivec3(7, 5, 3), glm::ivec3(1, 6, 6), glm::ivec3(9, 1, 1), glm::ivec3(1, 1, 1),
               glm::ivec3(3, 70, 2), glm::ivec3(2, 3, 1), glm::ivec3(5, 261, 2), glm::ivec3(270, 3, 2));
  const auto type = GENERATE(ScalarType::uint8, ScalarType::int16, ScalarType::float32, ScalarType::float64);
  const int gps = GENERATE(1, 2, 3, 5, 8);
  Grid grid;
  grid.dims = dims;
  grid.type = type;
  CAPTURE(dims.x, dims.y, dims.z, to_string(type), gps);
  CHECK(wrong_voxels(grid, gps, false) == 0);
  CHECK(wrong_voxels(grid, gps, true) == 0);
  for (const int bundle : {2, 3, 7, 1000}) CHECK(wrong_voxels(grid, {gps, bundle}, true) == 0);
}

TEST_CASE("every slice has one owner and the counts add up", "[slice_store]") {
  for (int slices = 0; slices < 12; ++slices)
    for (int gps = 1; gps < 15; ++gps)
      for (const int bundle : {1, 2, 3, 7, 1000}) {
        const SliceDealing dealing(gps, bundle);
        std::vector<int> places(std::size_t(gps), 0);
        for (int s = 0; s < slices; ++s) {
          const int owner = dealing.owner_of(s);
          REQUIRE(owner == s / bundle % gps);
          REQUIRE(dealing.place_of(s) == places[std::size_t(owner)]++);
          REQUIRE(dealing.slice_at(owner, dealing.place_of(s)) == s);
        }
        for (int g = 0; g < gps; ++g) {
          REQUIRE(dealing.owned_count(slices, g) == places[std::size_t(g)]);
          REQUIRE(dealing.owned_count(slices, g) <= dealing.owned_count(slices, 0));
        }
      }
  CHECK(SliceDealing(1 << 24, 1 << 20).owner_of(1 << 21) == 2);
  CHECK(SliceDealing(1 << 24, 1 << 20).owned_count(5, 0) == 5);
}

TEST_CASE("a store allocates what info predicts", "[slice_store]") {
  Grid grid;
  grid.dims = {33, 20, 11};
  grid.type = ScalarType::int16;
  for (const auto kept : {all_kept, std::array{false, true, false}, std::array{false, false, false}})
    for (const bool normals : {false, true})
      for (int gps = 1; gps <= 40; gps += 3) {
        std::uint64_t sum = 0;
        for (int g = 0; g < gps; ++g) {
          const SliceStore store(grid, g, gps, kept, normals);
          CHECK(store.allocated_bytes() == SliceStore::bytes_needed(grid, g, gps, kept, normals));
          const SliceStore bundles(grid, g, {gps, 4}, kept, normals);
          CHECK(bundles.allocated_bytes() == SliceStore::bytes_needed(grid, g, {gps, 4}, kept, normals));
          sum += store.allocated_bytes();
        }
        const auto sets = std::uint64_t(kept[0] + kept[1] + kept[2]);
        CHECK(sum == sets * std::uint64_t(grid.voxels()) * (normals ? 4 : 2));
      }
}

TEST_CASE("values and normals of different slices do not overlap and start at zero", "[slice_store]") {
  Grid grid;
  grid.dims = {4, 3, 6};
  SliceStore store(grid, 1, 2, all_kept, true);
  CHECK(store.owns(3));
  CHECK_FALSE(store.owns(2));
  for (const int z : {1, 3, 5}) {
    CHECK(store.values(Axis::z, z).size() == 12);
    for (const auto byte : store.values(Axis::z, z)) CHECK(byte == std::byte{0});
    std::memset(store.values(Axis::z, z).data(), z, 12);
    for (auto& normal : store.normals(Axis::z, z)) normal = std::uint16_t(z);
  }
  for (const int z : {1, 3, 5}) {
    const auto view = store.slice(Axis::z, z);
    CHECK(view.index == z);
    CHECK(view.width == 4);
    CHECK(view.height == 3);
    for (int i = 0; i < 12; ++i) {
      CHECK(view.values[i] == std::byte(z));
      CHECK(view.normals[i] == z);
    }
  }
  SliceStore plain(grid, 0, 1, all_kept, false);
  CHECK(plain.normals(Axis::z, 0).empty());
  CHECK(plain.slice(Axis::z, 0).normals == nullptr);
}

TEST_CASE("a slice store is of a GP that there is", "[slice_store]") {
  Grid grid;
  grid.dims = {4, 3, 2};
  CHECK_THROWS_AS(SliceStore(grid, 2, 2, all_kept, false), std::invalid_argument);
  CHECK_THROWS_AS(SliceStore(grid, 0, {2, 0}, all_kept, false), std::invalid_argument);
}
