// Volumes whose slices are decoded several together: who reads which, and what the GPs get.
#include <algorithm>
#include <mutex>

#include "classify/normals.hpp"
#include "ringsplat/base/error.hpp"
#include "ringsplat/volume/reduced.hpp"
#include "scene/scene.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/scenes.hpp"
#include "support/thread_collectives.hpp"
#include "volume/clipped.hpp"

using namespace ringsplat;
using ringsplat::test::make_grid;
using ringsplat::test::run_as_processes;
using ringsplat::test::ThreadCollectives;

namespace {

/// What all processes read of a volume.
struct Reads {
  std::mutex mutex;
  std::vector<std::pair<int, int>> ranges;  ///< first slice, number of slices

  /// How often each layer was decoded, if a reader decodes the whole layer for any of its slices.
  std::vector<int> of_layers(int depth, int slices) const {
    std::vector<int> counts(std::size_t((slices + depth - 1) / depth), 0);
    for (const auto& [first, count] : ranges)
      for (int layer = first / depth; layer <= (first + count - 1) / depth; ++layer)
        ++counts[std::size_t(layer)];
    return counts;
  }
};

class LayerSource final : public VolumeSource {
 public:
  LayerSource(const Grid& grid, std::span<const std::byte> voxels, int depth, bool concurrent, Reads& reads)
      : memory_(memory_source(grid, voxels)), depth_(depth), concurrent_(concurrent), reads_(reads) {}
  const Grid& grid() const override { return memory_->grid(); }
  bool concurrent() const override { return concurrent_; }
  int layer_depth() const override { return depth_; }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    memory_->read_slices(first, count, out);
    const std::lock_guard lock(reads_.mutex);
    reads_.ranges.emplace_back(first, count);
  }

 private:
  std::unique_ptr<VolumeSource> memory_;
  int depth_;
  bool concurrent_;
  Reads& reads_;
};

const Grid grid = make_grid({9, 7, 23});

std::vector<std::byte> make_voxels() {
  std::vector<std::byte> voxels(grid.bytes());
  for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = std::byte((i * i / 7 + 13 * i) % 251);
  return voxels;
}
const std::vector<std::byte> voxels = make_voxels();

using Open = std::function<std::unique_ptr<VolumeSource>()>;

/// Every GP's slices of every axis with their normals, dealt by four processes of which one has no GP.
std::vector<std::string> dealt(const Open& open, const LoadOptions& options) {
  const std::vector<int> process_of_gp{1, 0, 3, 3, 1};
  std::vector<std::string> all(5);
  const auto thrown = run_as_processes(4, [&](ThreadCollectives& collectives) {
    OpenedVolume volume = open_everywhere(collectives, open);
    const Scene scene = deal_scene(volume, options, {5, process_of_gp, collectives});
    for (const auto& [gp, level] : scene.stores) {
      std::string& text = all[std::size_t(gp)];
      for (const int factor : options.factors) {
        const SliceStore& store = level.level(factor);
        for (const Axis axis : all_axes)
          for (int s = 0; store.keeps(axis) && s < store.grid().slices(axis); ++s) {
            if (!store.owns(s)) continue;
            const auto slice = store.slice(axis, s);
            text.append(reinterpret_cast<const char*>(slice.values), store.grid().slice_bytes(axis));
            if (options.with_normals)
              text.append(reinterpret_cast<const char*>(slice.normals),
                          store.grid().slice_voxels(axis) * sizeof(NormalCode));
          }
      }
    }
  });
  for (const auto& text : thrown) CHECK(text.empty());
  return all;
}

std::vector<std::string> dealt_from_memory(const LoadOptions& options) {
  return dealt([] { return memory_source(grid, voxels); }, options);
}

}  // namespace

TEST_CASE("layers of any depth give the GPs the slices and normals of a raw volume, each read once") {
  LoadOptions clipped;
  clipped.clip = VoxelBox{{1, 2, 3}, {8, 6, 19}};
  LoadOptions unlit;
  unlit.with_normals = false;
  for (const LoadOptions& options : {LoadOptions{}, clipped, unlit}) {
    const auto expected = dealt_from_memory(options);
    CHECK(!expected[0].empty());
    for (const int depth : {1, 2, 5, 11, 64})
      for (const bool concurrent : {true, false}) {
        CAPTURE(depth, concurrent, options.with_normals, options.clip.has_value());
        Reads reads;
        const bool same =
            dealt([&] { return std::make_unique<LayerSource>(grid, voxels, depth, concurrent, reads); },
                  options) == expected;
        CHECK(same);
        // A volume without layers is read by the owners of slices themselves, neighbours too.
        if (depth == 1 && concurrent) continue;
        const auto counts = reads.of_layers(depth, grid.dims.z);
        CHECK(std::count(counts.begin(), counts.end(), 1) == std::ptrdiff_t(counts.size()));
      }
  }
}

TEST_CASE("levels of a volume in layers are those of a raw volume") {
  LoadOptions options;
  options.factors = {1, 2, 4};
  for (const bool prefilter : {false, true}) {
    options.prefilter = prefilter;
    const auto expected = dealt_from_memory(options);
    for (const int depth : {3, 8}) {
      Reads reads;
      const bool same = dealt([&] { return std::make_unique<LayerSource>(grid, voxels, depth, true, reads); },
                              options) == expected;
      CHECK(same);
    }
  }
}

TEST_CASE("a layer that cannot be read ends the dealing on all processes") {
  class Broken final : public VolumeSource {
   public:
    const Grid& grid() const override { return ::grid; }
    bool concurrent() const override { return true; }
    int layer_depth() const override { return 5; }
    void read_slices(int first, int, std::span<std::byte>) override {
      if (first >= 10) throw InputError("layer at 10 is damaged");
    }
  };
  const auto thrown = run_as_processes(4, [&](ThreadCollectives& collectives) {
    OpenedVolume volume = open_everywhere(collectives, [] { return std::make_unique<Broken>(); });
    deal_slices(volume, {}, {4, {0, 1, 2, 3}, collectives});
  });
  CHECK_THAT(thrown[0], Catch::Matchers::Contains("layer at 10 is damaged"));
  for (const auto& text : thrown) CHECK(text == thrown[0]);
}

TEST_CASE("loading tells how much of its time has passed, from its begin to its end") {
  Reads reads;
  for (const int depth : {1, 5, 64})
    for (const bool concurrent : {true, false}) {
      CAPTURE(depth, concurrent);
      std::vector<double> told;
      LoadOptions options;
      options.factors = {1, 2};
      options.told = [&](double part, bool) { told.push_back(part); };
      SoloCollectives solo;
      OpenedVolume volume = open_everywhere(
          solo, [&] { return std::make_unique<LayerSource>(grid, voxels, depth, concurrent, reads); });
      deal_scene(volume, options, {2, {0, 0}, solo});
      CHECK(told.size() >= 2);
      CHECK(std::is_sorted(told.begin(), told.end()));
      CHECK(told.front() >= 0);
      CHECK(told.back() == Approx(1));
    }
}

TEST_CASE("half of a volume gives it its levels, and only every second slice is read") {
  LoadOptions options;
  options.factors = {2, 4};
  const auto expected = dealt_from_memory(options);
  options.half_of = grid;
  Reads reads;
  const auto open = [&] {
    return skipping_source(std::make_unique<LayerSource>(grid, voxels, 1, true, reads),
                           reduced_grid(grid, {2}), 2);
  };
  const bool same = dealt(open, options) == expected;
  CHECK(same);
  CHECK(std::ranges::none_of(reads.ranges, [](const auto& range) { return range.first % 2 != 0; }));
}
