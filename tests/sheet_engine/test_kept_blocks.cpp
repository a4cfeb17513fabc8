#include <fmt/format.h>

#include "session/render.hpp"
#include "sheet_engine/kept_blocks.hpp"
#include "sheet_engine/scalar_planes.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"
#include "support/views.hpp"
#include "volume/forwarding_source.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

FrameSpec seen_from(double azimuth) {
  FrameSpec spec = oblique_view(64, 56, 0);
  spec.shown.camera = {.azimuth = azimuth, .elevation = 21};
  spec.how = Sheets{};
  return spec;
}

/// A viewer's frames: it turns, and now and then the function, the method, the part or the level changes.
/// `most`: the volume's largest value. `tinted`: most of them, by the segmentation.
std::vector<FrameSpec> browsed_frames(int count, double most = 255, bool tinted = false) {
  std::vector<FrameSpec> specs;
  for (int k = 0; k < count; ++k) {
    FrameSpec spec = seen_from(17.0 * k);
    if (k / 3 % 3 == 1) spec.shown.transfer_function = ramp(100, 255, 0.8);
    // Two gaps between visible values: other fillers.
    if (k / 3 % 3 == 2)
      spec.shown.transfer_function.opacities = {{20, 0.5}, {30, 0}, {60, 0}, {90, 0.2}, {120, 0}, {255, 0}};
    spec.as<Sheets>().slabs = 1 + k / 2 % 3;
    if (k % 7 >= 5) spec.shown.clip = VoxelBox{{3, 5, 9}, {36, 31, 40}};
    if (k % 5 == 4) spec.shown.reduction.factor = 2;
    if (k % 11 >= 9) spec.shown.shading = Shading::none;
    if (tinted && k % 8 < 6) spec.shown.tints = {{1, {1, 0, 0}, 0.6F}, {3, {0, 0, 1}, 1.0F}};
    for (auto& point : spec.shown.transfer_function.colours) point.value *= most / 255;
    for (auto& point : spec.shown.transfer_function.opacities) point.value *= most / 255;
    specs.push_back(spec);
  }
  return specs;
}

/// The jack, in whose place a segmentation has four labels.
class Labelled final : public ForwardingSource {
 public:
  explicit Labelled(const Grid& grid) : ForwardingSource(synth_source("jack", grid)), labels_(grid) {}
  VolumeSource* labels() override { return &labels_; }

 private:
  class Cells final : public VolumeSource {
   public:
    explicit Cells(Grid grid) : grid_(std::move(grid)) { grid_.type = ScalarType::uint8; }
    const Grid& grid() const override { return grid_; }
    bool concurrent() const override { return true; }
    void read_slices(int first, int count, std::span<std::byte> out) override {
      std::size_t i = 0;
      for (int z = first; z < first + count; ++z)
        for (int y = 0; y < grid_.dims.y; ++y)
          for (int x = 0; x < grid_.dims.x; ++x) out[i++] = std::byte((x / 9 + y / 7 + 2 * (z / 12)) % 4);
    }

   private:
    Grid grid_;
  };
  Cells labels_;
};

const LoadOptions everything{.factors = {1, 2}, .with_cell_ranges = true};

struct Browsed {
  std::map<std::int64_t, Image> pictures;
  std::vector<std::uint64_t> bytes;  ///< of payloads, by frame that was finished
};

Browsed browse(const Grid& grid, const std::vector<FrameSpec>& specs, const Layout& layout, int keep,
               std::uint64_t seed = 0, std::function<bool(const FrameSpec&)> unwanted = {}) {
  SoloCollectives solo;
  const Wiring wiring{solo, nullptr, {.seed = seed, .reorder = seed > 0, .max_delay = int(seed % 5)}};
  OpenedVolume volume{grid, true, std::make_unique<Labelled>(grid)};
  volume.has_labels = true;
  Scene scene = load_scene(volume, everything, layout, wiring);
  Browsed browsed;
  Director director = director_of(specs, [&](FrameResult&& r) {
    browsed.bytes.push_back(r.stats.total().payload_bytes_sent);
    browsed.pictures[r.spec.frame] = std::move(r.image);
  });
  director.unwanted = std::move(unwanted);
  EngineOptions engine;
  engine.keep = keep;
  render_frames(
      std::move(scene), layout,
      {.frames_in_flight = 1 + int(seed % 3), .slots = 1 + int(seed % 4), .send_ahead = int(seed % 3)},
      std::move(director), wiring, engine);
  return browsed;
}

}  // namespace

TEST_CASE("frames have the bits that they have alone, whatever Renderers keep of those before") {
  for (const auto& [type, tinted] :
       {std::pair{ScalarType::uint8, false}, {ScalarType::float32, false}, {ScalarType::uint8, true}}) {
    const auto specs = browsed_frames(22, type == ScalarType::uint8 ? 255 : 1, tinted);
    const Grid grid = make_grid({64, 64, 64}, type);
    std::vector<Image> alone;
    for (const FrameSpec& spec : specs) {
      alone.push_back(browse(grid, {spec}, {1, 1}, 0).pictures.at(0));
      REQUIRE(*std::max_element(alone.back().rgba.begin(), alone.back().rgba.end()) > 0.05F);
    }
    // One MiB is a part of a shelf of floats, or a shelf of whole numbers and the rest of another.
    for (const int keep : {0, 1, 64})
      for (const std::uint64_t seed : {0U, 1U, 2U}) {
        INFO(fmt::format("{} values, tinted {}, {} MiB, seed {}", to_string(type), tinted, keep, seed));
        Layout layout{1 + int(seed), 1 + int(seed % 3)};
        layout.bundle = 1 + int(seed % 2) * 2;
        const auto browsed = browse(grid, specs, layout, keep, seed);
        REQUIRE(browsed.pictures.size() == specs.size());
        for (const auto& [frame, image] : browsed.pictures) REQUIRE(image == alone[std::size_t(frame)]);
      }
  }
}

TEST_CASE("frames that nobody wants any more leave what later ones rely on") {
  const auto specs = browsed_frames(15);
  const Grid grid = make_grid({40, 40, 40});
  std::vector<Image> alone;
  for (const FrameSpec& spec : specs) alone.push_back(browse(grid, {spec}, {1, 1}, 0).pictures.at(0));
  std::size_t dropped = 0;
  for (std::uint64_t seed = 1; seed < 40; seed += 2) {
    std::map<std::int64_t, int> asked;
    const auto unwanted = [&](const FrameSpec& spec) {
      return spec.frame % 3 == 1 && ++asked[spec.frame] > int(37 * seed % 400);
    };
    const auto browsed = browse(grid, specs, {1 + int(seed % 4), 1 + int(seed % 3)}, 64, seed, unwanted);
    INFO(fmt::format("seed {}", seed));
    for (const auto& [frame, image] : browsed.pictures) REQUIRE(image == alone[std::size_t(frame)]);
    dropped += specs.size() - browsed.pictures.size();
  }
  CHECK(dropped > 20);
}

TEST_CASE("a frame of which nothing can be kept leaves what is kept of others") {
  // One plane of the whole volume is more than a MiB, one of its part is not.
  const Grid grid = make_grid({800, 800, 4});
  std::vector<FrameSpec> specs(3, seen_from(0));
  for (std::size_t k = 0; k < specs.size(); ++k) {
    specs[k].shown.camera = {.azimuth = 0, .elevation = 80};
    if (k != 1) specs[k].shown.clip = VoxelBox{{300, 300, 0}, {500, 500, 4}};
  }
  const auto browsed = browse(grid, specs, {1, 1}, 1);
  REQUIRE(browsed.pictures.size() == 3);
  CHECK(10 * browsed.bytes[2] < browsed.bytes[0]);
  for (std::size_t k = 0; k < specs.size(); ++k)
    CHECK(browsed.pictures.at(std::int64_t(k)) == browse(grid, {specs[k]}, {1, 1}, 0).pictures.at(0));
}

TEST_CASE("an orbit's later frames send few bytes, unless nothing may be kept") {
  const Grid grid = make_grid({64, 64, 64});
  std::vector<FrameSpec> orbit;
  for (int k = 0; k < 8; ++k) orbit.push_back(seen_from(-28.0 + 8 * k));
  const auto bytes = [&](int keep) { return browse(grid, orbit, {2, 2}, keep).bytes; };
  const auto none = bytes(0), all = bytes(64);
  CHECK(all.front() == none.front());
  for (std::size_t frame = 1; frame < orbit.size(); ++frame) {
    CHECK(10 * all[frame] < none[frame]);
    CHECK(10 * none[frame] > 9 * none.front());
  }
}

TEST_CASE("shelves that were not used for longest make room, and come back empty") {
  const auto begin = [](KeptBlocks& kept, std::int64_t number, double azimuth) {
    FrameSpec spec = seen_from(azimuth);
    spec.frame = number;
    const auto frame = make_sheet_frame(spec, make_grid({64, 64, 64}), 1, 1);
    return kept.begin_frame(*frame, value_scale(*frame, 0, 255));
  };
  constexpr std::uint64_t two_shelves = 2 * 64 * 80 * 80 * 2;
  KeptBlocks kept(0, 1, 1, two_shelves);
  const auto first = begin(kept, 0, 0), second = begin(kept, 1, 90), again = begin(kept, 2, 3);
  REQUIRE(first.shelf != nullptr);
  CHECK(second.number.shelf != first.number.shelf);
  CHECK(again.shelf == first.shelf);
  CHECK(again.number.generation == first.number.generation);
  FrameSpec above = seen_from(0);
  above.shown.camera.elevation = 80;
  above.frame = 3;
  const auto frame = make_sheet_frame(above, make_grid({64, 64, 64}), 1, 1);
  const auto third = kept.begin_frame(*frame, value_scale(*frame, 0, 255));
  // The second one's place: the first was used later.
  CHECK(third.number.shelf == second.number.shelf);
  CHECK(third.number.generation != second.number.generation);
  CHECK(begin(kept, 4, 0).shelf == first.shelf);
  const auto anew = begin(kept, 5, 90);
  CHECK(anew.shelf != second.shelf);
  CHECK_FALSE(anew.shelf->held(0, 0)[0]);
  KeptBlocks nothing(0, 1, 1, 1000);
  CHECK(begin(nothing, 0, 0).shelf == nullptr);
}

TEST_CASE("a Renderer keeps its share of 2 GiB or of a quarter of all slices, and no more than all planes") {
  constexpr std::uint64_t mib = 1 << 20;
  const Grid large = make_grid({1024, 1024, 1024}), huge = make_grid({4096, 4096, 1024});
  CHECK(usual_kept_bytes(make_grid({100, 100, 100}), 1) == 3 * 100 * plane_bytes(100, 100, {.floats = true}));
  CHECK(usual_kept_bytes(large, 2) == 1024 * mib);
  CHECK(usual_kept_bytes(large, 64) == 256 * mib);
  CHECK(usual_kept_bytes(huge, 4) == 3 * std::uint64_t(huge.bytes()) / 4 / 4);
}
