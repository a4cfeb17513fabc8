// Processes that see different volumes report it before any voxel is dealt.
#include <atomic>
#include <utility>

#include "formats/files.hpp"
#include "ringsplat/base/error.hpp"
#include "scene/scene.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/scenes.hpp"
#include "support/thread_collectives.hpp"
#include "volume/cell_ranges.hpp"

using namespace ringsplat;
using files::Folder;
using ringsplat::test::make_grid;
using ringsplat::test::run_as_processes;
using ringsplat::test::ThreadCollectives;

namespace {

constexpr glm::ivec3 dims{8, 8, 12};

std::string voxels(char first = 'a') {
  std::string bytes(std::size_t(dims.x * dims.y * dims.z), 'v');
  bytes.front() = first;
  return bytes;
}

using Open = std::function<std::unique_ptr<VolumeSource>(int process)>;

/// The error that all three processes get, which must be the same, when process p opens `open(p)`.
std::string refusal(const Open& open) {
  const auto thrown = run_as_processes(3, [&](ThreadCollectives& collectives) {
    open_everywhere(
        collectives, [&] { return open(collectives.process()); }, "the head");
  });
  CHECK(thrown[1] == thrown[0]);
  CHECK(thrown[2] == thrown[0]);
  return thrown[0];
}

}  // namespace

TEST_CASE("a volume in memory of all processes must have one grid") {
  const Grid grid = make_grid(dims);
  Grid other = grid;
  other.dims = {12, 8, 8};
  const std::string bytes = voxels();
  const auto in_memory = [&](const Grid& g) { return memory_source(g, std::as_bytes(std::span(bytes))); };
  CHECK(refusal([&](int) { return in_memory(grid); }).empty());
  CHECK_THAT(
      refusal([&](int p) { return in_memory(p == 2 ? other : grid); }),
      Catch::Matchers::Contains("rank 2 sees another volume at the head: dimensions 12 x 8 x 8, rank 0 has "
                                "8 x 8 x 12"));
  other = grid;
  other.origin.y = 1e-300;
  CHECK_THAT(refusal([&](int p) { return in_memory(p == 1 ? other : grid); }),
             Catch::Matchers::Contains(
                 "rank 1 sees another volume at the head: origin 0 1e-300 0, rank 0 has 0 0 0"));
  other = grid;
  other.origin.y = -0.0;
  CHECK(refusal([&](int p) { return in_memory(p == 1 ? other : grid); }).empty());
}

TEST_CASE("a file must have the same bytes for all processes that read it") {
  const Folder folder;
  const auto good = files::write(folder / "good_8x8x12_uint8.raw", voxels());
  const auto copy = files::write(folder / "copy_8x8x12_uint8.raw", voxels());
  const auto odd = files::write(folder / "odd_8x8x12_uint8.raw", voxels('b'));
  CHECK(refusal([&](int p) { return open_volume(p == 0 ? good : copy); }).empty());
  CHECK_THAT(refusal([&](int p) { return open_volume(p == 2 ? odd : good); }),
             Catch::Matchers::Contains("rank 2 sees another volume at the head: hash of the first bytes"));
  CHECK_THAT(refusal([&](int p) { return open_volume(p == 0 ? odd : good); }),
             Catch::Matchers::Contains("rank 1 sees another volume at the head: hash of the first bytes") &&
                 Catch::Matchers::Contains("(1 more rank differs)"));
}

TEST_CASE("all that a file says of its voxels, and where they lie in it, must be the same") {
  const Folder folder;
  const auto nrrd = [](const std::string& fields) {
    return "NRRD0004\ndimension: 3\nencoding: raw\n" + fields + "\n" + voxels();
  };
  const std::string plain = nrrd("type: uint8\nsizes: 8 8 12\n"),
                    shorts = nrrd("type: int16\nsizes: 4 8 12\nendian: little\n");
  const std::vector<std::array<std::string, 3>> cases{
      {plain, nrrd("type: int8\nsizes: 8 8 12\n"), "type int8, rank 0 has uint8"},
      {plain, nrrd("type: uint8\nsizes: 8 8 12\nspacings: 1 1 2\n"), "spacing 1 1 2, rank 0 has 1 1 1"},
      {plain, nrrd("type: uint8\nsizes: 8 8 12\n# a remark\n"), "offset "},
      {shorts, nrrd("type: int16\nsizes: 4 8 12\nendian: big\n"), "byte order big, rank 0 has little"},
      {plain, plain + "more", "file size "}};
  for (const auto& [first, other, words] : cases) {
    const auto a = files::write(folder / "a.nrrd", first), b = files::write(folder / "b.nrrd", other);
    CHECK_THAT(refusal([&](int p) { return open_volume(p == 1 ? b : a); }), Catch::Matchers::Contains(words));
  }
}

TEST_CASE("what rank 0 alone decodes is asked of nobody else") {
  const Folder folder;
  const auto path = files::write(
      folder / "a.nrrd",
      "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 8 8 12\nencoding: gzip\n\n" + files::gzip(voxels()));
  CHECK(refusal([&](int p) {
          if (p != 0) throw InputError("only rank 0 has the file");
          return open_volume(path);
        }).empty());
}

TEST_CASE("a file that becomes shorter on one process ends the dealing on all") {
  const Folder folder;
  std::vector<std::filesystem::path> paths;
  for (const char* name : {"0", "1", "2"}) {
    std::filesystem::create_directory(folder / name);
    paths.push_back(files::write(folder / (std::string(name) + "/a_8x8x12_uint8.raw"), voxels()));
  }
  const auto thrown = run_as_processes(3, [&](ThreadCollectives& collectives) {
    const auto& path = paths[std::size_t(collectives.process())];
    OpenedVolume volume = open_everywhere(collectives, [&] { return open_volume(path); });
    if (collectives.process() == 1) std::filesystem::resize_file(path, 100);
    deal_slices(volume, {}, {3, {0, 1, 2}, collectives});
  });
  CHECK_THAT(thrown[0],
             Catch::Matchers::Contains("1/a_8x8x12_uint8.raw") && Catch::Matchers::Contains("on rank 1"));
  CHECK(thrown[1] == thrown[0]);
  CHECK(thrown[2] == thrown[0]);
}

TEST_CASE("a process without slices has its part in what all gather") {
  const Grid grid = make_grid(dims);
  const std::string bytes = voxels();
  std::vector<std::size_t> known(3, 0);
  std::vector<ValueRange> ranges(3);
  std::atomic<bool> in_order = true;
  const auto thrown = run_as_processes(3, [&](ThreadCollectives& collectives) {
    const auto process = std::size_t(collectives.process());
    OpenedVolume volume =
        open_everywhere(collectives, [&] { return memory_source(grid, std::as_bytes(std::span(bytes))); });
    auto stores = deal_slices(volume, {}, {2, {0, 2}, collectives});
    share_slice_ranges(stores, collectives);
    ranges[process] = share_values(stores, grid, {}, collectives).range;
    for (const auto& [gp, store] : stores) {
      const auto all = store.ranges(Axis::z);
      known[process] = all.size();
      for (std::size_t k = 0; k < all.size(); ++k)
        if (all[k].slice != int(k)) in_order = false;
    }
  });
  CHECK(thrown == std::vector<std::string>(3));
  CHECK(known == std::vector<std::size_t>{12, 0, 12});
  CHECK(in_order);
  for (const ValueRange& range : ranges) {
    CHECK(range.low == 'a');
    CHECK(range.high == 'v');
  }
}
