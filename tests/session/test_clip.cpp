#include <fmt/format.h>

#include <cstring>
#include <glm/common.hpp>

#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/message_of.hpp"
#include "support/views.hpp"
#include "volume/cell_ranges.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

constexpr glm::ivec3 dims{41, 37, 45};

struct Volume {
  Grid grid;
  std::vector<std::byte> voxels;
  std::unique_ptr<VolumeSource> source() const { return memory_source(grid, voxels); }
};

Volume volume_of(const std::string& name, ScalarType type = ScalarType::uint8) {
  const auto source = synth_source(name, make_grid(dims, type));
  Volume volume{source->grid(), std::vector<std::byte>(source->grid().bytes())};
  source->read_slices(0, dims.z, volume.voxels);
  return volume;
}

/// The volume cropped to the box, at its place.
Volume crop(const Volume& whole, const VoxelBox& box) {
  Volume part{whole.grid, {}};
  part.grid.dims = box.end - box.first;
  part.grid.origin = glm::dvec3(box.first);  // of a lattice of unit voxels
  const std::size_t scalar = size_of(whole.grid.type);
  for (int z = box.first.z; z < box.end.z; ++z)
    for (int y = box.first.y; y < box.end.y; ++y) {
      const std::size_t row = (std::size_t(z) * std::size_t(dims.y) + std::size_t(y)) * std::size_t(dims.x);
      part.voxels.insert(part.voxels.end(),
                         whole.voxels.begin() + std::ptrdiff_t((row + std::size_t(box.first.x)) * scalar),
                         whole.voxels.begin() + std::ptrdiff_t((row + std::size_t(box.end.x)) * scalar));
    }
  return part;
}

/// A view along `axis` whose numbers are so short that positions are exact: the same bits, whichever lattice
/// they are computed from.
Camera exact_view(Axis axis, bool ascending) {
  const int k = static_cast<int>(axis), u = (k + 1) % 3, v = (k + 2) % 3;
  const double toward = ascending ? 1 : -1;
  std::array<double, 12> m{};
  const auto set = [&](int row, double along_u, double along_v, double along_k, double offset) {
    m[std::size_t(4 * row + u)] = along_u;
    m[std::size_t(4 * row + v)] = along_v;
    m[std::size_t(4 * row + k)] = along_k;
    m[std::size_t(4 * row + 3)] = offset;
  };
  set(0, 1.75, 0.125, 0.25, 6);
  set(1, -0.25, 1.5, -0.375, 24);
  set(2, 0.25, -0.125, 1.5 * toward, 0);
  return {.matrix = m};
}

FrameSpec spec_for(const Method& how, Shading shading, const Camera& camera) {
  FrameSpec spec = oblique_view(100, 96, 0);
  spec.how = how;
  spec.shown.camera = camera;
  spec.shown.shading = shading;
  spec.shown.transfer_function = ramp(30, 255, 0.6);
  return spec;
}

/// The range of all voxels of a level, which sheets' tables depend on.
SliceRange range_of(const SliceStore& store, Axis axis) {
  SliceRange all{axis, 0, INFINITY, -INFINITY};
  for (const SliceRange& r : store.ranges(axis)) {
    all.low = std::min(all.low, r.low);
    all.high = std::max(all.high, r.high);
  }
  return all;
}

/// Tells the stores of a part that its values have the whole volume's range.
void tell_range(std::map<int, SliceStore>& parts, const SliceStore& whole, int factor) {
  for (auto& [gp, store] : parts) {
    SliceStore level = store.level(factor);
    SliceRanges ranges;
    for (const Axis axis : all_axes)
      for (int s = 0; level.keeps(axis) && s < level.grid().slices(axis); ++s) {
        auto& of_axis = ranges[std::size_t(axis)];
        of_axis.push_back(range_of(whole.level(factor), axis));
        of_axis.back().slice = s;
      }
    level.know_ranges(std::make_shared<const SliceRanges>(ranges));
    if (factor == 1)
      store = std::move(level);
    else
      store.add_level(factor, std::move(level));
  }
}

Image draw(Scene scene, const FrameSpec& spec, const Wiring& wiring) {
  Image image;
  const auto keep = [&](FrameResult&& r) { image = std::move(r.image); };
  render_frames(std::move(scene), {1, 1}, {}, director_of({spec}, keep), wiring);
  return image;
}

/// The cropped volume's picture.
Image picture_of_crop(const Volume& whole, FrameSpec spec) {
  SoloCollectives solo;
  const Wiring wiring{solo};
  const Volume part = crop(whole, *spec.shown.clip);
  OpenedVolume opened_whole{whole.grid, true, whole.source()}, opened{part.grid, true, part.source()};
  spec.shown.clip.reset();
  const Scene all = load_scene(opened_whole, needed_to_render(spec, whole.grid), {1, 1}, wiring);
  Scene scene = load_scene(opened, needed_to_render(spec, part.grid), {1, 1}, wiring);
  tell_range(scene.stores, all.stores.at(0), spec.shown.reduction.factor);
  return draw(std::move(scene), spec, wiring);
}

Splats in_slices_plane() {
  Splats splats;
  splats.image_plane = ImagePlane::slices;
  splats.plane_samples = 2;
  return splats;
}

struct Case {
  const char* name;
  Method how;
};
const std::vector<Case> methods{
    {"splats", Splats{}},
    {"splats in the slices' plane", in_slices_plane()},
    {"sheets", Sheets{}},
    {"sheets in the slices' plane", Sheets{.image_plane = ImagePlane::slices, .plane_samples = 1.5}},
    {"three slabs", Sheets{.slabs = 3, .light_points = 1, .adaptive = false}}};

const std::vector<VoxelBox> boxes{{{3, 5, 7}, {38, 30, 40}},    {{16, 8, 24}, {32, 24, 40}},
                                  {{0, 11, 20}, {41, 12, 45}},  {{13, 0, 0}, {14, 37, 45}},
                                  {{20, 17, 21}, {21, 18, 22}}, {{9, 10, 22}, {33, 31, 23}}};

}  // namespace

TEST_CASE("a clipped picture has the bits of the cropped volume's, along all axes and with each engine") {
  const Volume whole = volume_of("gaussians");
  int seen = 0;
  for (const auto& [name, how] : methods)
    for (const Shading shading : {Shading::none, Shading::phong})
      for (const Axis axis : all_axes)
        for (const bool ascending : {true, false})
          for (const VoxelBox& box : boxes) {
            FrameSpec spec = spec_for(how, shading, exact_view(axis, ascending));
            spec.shown.clip = box;
            INFO(fmt::format("{}, {}, axis {}, {}, box from {},{},{}", name,
                             shading == Shading::phong ? "lit" : "unlit", ringsplat::name(axis),
                             ascending ? "ascending" : "descending", box.first.x, box.first.y, box.first.z));
            const Image image = render_loopback(*whole.source(), spec, 1, 1).image;
            REQUIRE(image == picture_of_crop(whole, spec));
            seen += brightest(image) > 0.05F;
          }
  CHECK(seen > 275);
}

TEST_CASE("clipped pictures of other types of voxels have the cropped volume's bits") {
  for (const ScalarType type : {ScalarType::uint16, ScalarType::float32}) {
    const Volume whole = volume_of("jack", type);
    for (const auto& [name, how] : methods) {
      FrameSpec spec = spec_for(how, Shading::phong, exact_view(Axis::y, true));
      spec.shown.transfer_function = type == ScalarType::float32 ? ramp(0.1, 1, 0.6) : ramp(5000, 65535, 0.6);
      spec.shown.clip = boxes[0];
      INFO(fmt::format("{} of {}", name, to_string(type)));
      const Image image = render_loopback(*whole.source(), spec, 1, 1).image;
      REQUIRE(brightest(image) > 0.05F);
      CHECK(image == picture_of_crop(whole, spec));
    }
  }
}

TEST_CASE("an undersampled clipped picture has the bits of the cropped volume's") {
  const Volume whole = volume_of("gaussians");
  for (const int factor : {2, 4})
    for (const auto& [name, how] : methods)
      for (const Axis axis : all_axes) {
        FrameSpec spec = spec_for(how, Shading::phong, exact_view(axis, axis != Axis::y));
        spec.shown.reduction = {factor, false};
        spec.shown.clip = VoxelBox{{4, 8, 12}, {36, 32, 44}};
        INFO(fmt::format("{}, factor {}, axis {}", name, factor, ringsplat::name(axis)));
        const Image image = render_loopback(*whole.source(), spec, 1, 1).image;
        REQUIRE(brightest(image) > 0.05F);
        CHECK(image == picture_of_crop(whole, spec));
      }
}

TEST_CASE("a box of the whole volume changes no bit") {
  const Volume whole = volume_of("jack");
  for (const auto& [name, how] : methods)
    for (const Reduction& reduction : {Reduction{}, Reduction{4, true}}) {
      FrameSpec spec = spec_for(how, Shading::phong, {.azimuth = 33, .elevation = 21});
      spec.shown.reduction = reduction;
      const Image all = render_loopback(*whole.source(), spec, 1, 1).image;
      REQUIRE(brightest(all) > 0.05F);
      spec.shown.clip = whole_box(whole.grid);
      INFO(name);
      CHECK(render_loopback(*whole.source(), spec, 1, 1).image == all);
    }
}

TEST_CASE("a clipped picture has the same bits for any ranks, regions, meshes and order of messages") {
  const Volume whole = volume_of("jack");
  for (const auto& [name, how] : methods)
    for (const int factor : {1, 2}) {
      FrameSpec spec = spec_for(how, Shading::phong, {.azimuth = 123, .elevation = -30, .zoom = 1.3});
      spec.shown.reduction = {factor, factor == 2};
      spec.shown.clip = VoxelBox{{5, 3, 6}, {30, 34, 41}};
      const auto source = whole.source();
      const Image alone = render_loopback(*source, spec, 1, 1).image;
      REQUIRE(brightest(alone) > 0.05F);
      const LoopbackOptions shuffled{.seed = 7, .reorder = true};
      INFO(fmt::format("{}, factor {}", name, factor));
      CHECK(render_loopback(*source, spec, 3, 2, shuffled).image == alone);
      CHECK(render_loopback(*source, spec, 7, 4, shuffled, Placement::colocated).image == alone);
      CHECK(render_loopback(*source, spec, mesh_layout(3, 2, 3), shuffled).image == alone);
      if (spec.division.region_size = 20; !std::holds_alternative<Splats>(how) || factor == 1)
        CHECK(render_loopback(*source, spec, 5, 3, shuffled).image == alone);
    }
}

TEST_CASE("slices outside of the clip box get no token and no payload, and blocks outside are not sent") {
  const Volume whole = volume_of("constant");
  for (const Method& how : {Method{Splats{}}, Method{Sheets{}}}) {
    FrameSpec spec = spec_for(how, Shading::none, exact_view(Axis::z, true));
    spec.shown.transfer_function = constant_opacity(0.01);
    const NodeStats all = render_loopback(*whole.source(), spec, 4, 1).stats.total();
    CHECK(all.slices == 45);
    spec.shown.clip = VoxelBox{{8, 8, 10}, {24, 16, 19}};
    const NodeStats some = render_loopback(*whole.source(), spec, 4, 1).stats.total();
    INFO(name(how));
    CHECK(some.slices == 9);
    CHECK(some.payloads_sent == 9);
    CHECK(some.tokens_passed == 8);
    CHECK(some.visible_voxels == 16 * 8 * 9);
    CHECK(some.payload_bytes_sent < all.payload_bytes_sent / 20);
  }
}

TEST_CASE("the clip box may change from frame to frame, also while others are in flight") {
  const Volume whole = volume_of("jack");
  for (const Method& how : {Method{Splats{}}, Method{Sheets{}}}) {
    const Shading shading = std::holds_alternative<Sheets>(how) ? Shading::phong : Shading::none;
    const auto spec_of = [&](std::size_t k) {
      FrameSpec spec = spec_for(how, shading, {.azimuth = 20, .elevation = 75});
      const int at = int(k % 5);
      if (at < 4) spec.shown.clip = VoxelBox{{3 * at, 2, 5 * at}, {41 - at, 37 - 6 * at, 30 + 4 * at}};
      if (at == 2) spec.shown.transfer_function = ramp(90, 200, 0.3);
      return spec;
    };
    std::vector<FrameSpec> specs;
    std::vector<Image> alone;
    for (std::size_t k = 0; k < 15; ++k) specs.push_back(spec_of(k));
    for (std::size_t k = 0; k < 5; ++k)
      alone.push_back(render_loopback(*whole.source(), specs[k], 1, 1).image);
    REQUIRE(alone[0] != alone[1]);
    std::size_t seen = 0;
    const auto compare = [&](FrameResult&& result) { CHECK(result.image == alone[seen++ % 5]); };
    render_directed(*whole.source(), needed_to_render(specs[0], whole.grid), {.gps = 3, .renderers = 2},
                    director_of(specs, compare), {}, {.frames_in_flight = 4, .look_ahead = 3});
    CHECK(seen == 15);
  }
}

TEST_CASE("lit splats are drawn within the clip box only that their normals were made for") {
  const Volume whole = volume_of("jack");
  FrameSpec spec = spec_for(Splats{}, Shading::phong, {.azimuth = 20});
  SoloCollectives solo;
  const Wiring wiring{solo};
  const auto draw_other = [&](const std::optional<VoxelBox>& loaded, const std::optional<VoxelBox>& shown) {
    OpenedVolume opened{whole.grid, true, whole.source()};
    spec.shown.clip = loaded;
    Scene scene = load_scene(opened, needed_to_render(spec, whole.grid), {1, 1}, wiring);
    spec.shown.clip = shown;
    return message_of<RunError>([&] { static_cast<void>(draw(std::move(scene), spec, wiring)); });
  };
  using Catch::Matchers::Contains;
  CHECK_THAT(draw_other(boxes[0], boxes[1]), Contains("lit within another clip box"));
  CHECK_THAT(draw_other(std::nullopt, boxes[1]), Contains("lit within another clip box"));
  CHECK_THAT(draw_other(boxes[1], std::nullopt), Contains("lit within another clip box"));
  CHECK(draw_other(std::nullopt, whole_box(whole.grid)).empty());
}

TEST_CASE("a clip box that is none of the volume's is refused, and the axis is named") {
  const Volume whole = volume_of("jack");
  const auto refusal = [&](const VoxelBox& box) {
    FrameSpec spec = spec_for(Sheets{}, Shading::phong, {});
    spec.shown.clip = box;
    return message_of([&] { static_cast<void>(render_loopback(*whole.source(), spec, 1, 1)); });
  };
  using Catch::Matchers::Contains;
  CHECK_THAT(refusal({{-1, 0, 0}, {41, 37, 45}}), Contains("x part, -1:41, does not lie within"));
  CHECK_THAT(refusal({{0, 0, 0}, {41, 38, 45}}), Contains("y part, 0:38, does not lie within"));
  CHECK_THAT(refusal({{0, 0, 9}, {41, 37, 9}}), Contains("z part, 9:9, has no voxel"));
  CHECK_THAT(refusal({{0, 0, 0}, {41, 37, 1 << 30}}), Contains("z part"));
}
