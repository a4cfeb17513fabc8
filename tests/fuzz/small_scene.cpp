#include "fuzz/small_scene.hpp"

#include <cstring>
#include <stdexcept>

#include "frame/frame_spec_bytes.hpp"
#include "net/message.hpp"
#include "support/scenes.hpp"

namespace ringsplat::fuzz {

Grid small_grid() { return test::make_grid({12, 10, 9}); }

FrameSpec small_frame(unsigned choice) {
  FrameSpec spec{.how = Splats{}};
  spec.shown.camera = {.azimuth = 33, .elevation = 21, .roll = 8, .zoom = 1.2};
  spec.shown.width = 48;
  spec.shown.height = 40;
  spec.division.region_size = 16;
  spec.shown.transfer_function = test::ramp(20, 255, 0.9);
  spec.division.dealt_to = small_renderers;
  if (choice % 2 == 1) spec.shown.shading = Shading::none;
  switch (choice / 2 % 4) {
    case 1:
      spec.as<Splats>().image_plane = ImagePlane::slices;
      spec.as<Splats>().plane_samples = 1 << choice % 3;
      break;
    case 2:
      spec.shown.camera.zoom = 60;
      break;
    case 3:
      spec.shown.camera.zoom = 8;
      spec.division.region_size = 37;
      break;
    default:
      spec.shown.opaque_threshold = 0.1;
  }
  return spec;
}

SliceStore patterned_slices(const Grid& grid) {
  SliceStore store(grid, 0, 1, {true, true, true}, true);
  for (const Axis axis : all_axes)
    for (int s = 0; s < grid.slices(axis); ++s) {
      const auto values = store.values(axis, s);
      for (std::size_t k = 0; k < values.size(); ++k) values[k] = std::byte(37 * k + 11 * std::size_t(s));
      const auto normals = store.normals(axis, s);
      for (std::size_t k = 0; k < normals.size(); ++k) normals[k] = std::uint16_t(k * 97);
    }
  return store;
}

namespace {

SliceStore slices_with_level(const Grid& grid, const Reduction& reduction) {
  SliceStore store = patterned_slices(grid);
  if (reduction.factor > 1)
    store.add_level(reduction.factor, patterned_slices(reduced_grid(grid, reduction)));
  return store;
}

}  // namespace

SmallRun::SmallRun(const FrameSpec& spec, const Grid& grid)
    : frame_(std::make_shared<SplatFrame>(spec, make_geometry(spec, grid), 1, small_renderers)),
      slices_(slices_with_level(grid, spec.shown.reduction)),
      encoder_(make_splat_encoder(frame_, small_renderers, slices_, empty_space_, alone_)),
      painter_(make_splat_painter(0, alone_)) {
  painter_->begin_frame(frame_);
}

Bytes SmallRun::encode(int step) {
  encoder_->begin(step);
  while (!encoder_->work()) {
  }
  return encoder_->finish().parts[0].payload;
}

void SmallRun::draw(int step, std::span<const std::byte> payload) {
  painter_->begin({.step = step, .body = payload});
  while (!painter_->work()) {
  }
}

void SmallRun::finish() {
  painter_->finish([](int, const Bytes& tile) {
    for (std::size_t at = sizeof(Header); at + sizeof(float) <= tile.size(); at += sizeof(float)) {
      float value = 0;
      std::memcpy(&value, tile.data() + at, sizeof value);
      if (!(value >= 0 && value <= 1.0001F)) throw std::logic_error("a picture has a value outside 0..1");
    }
  });
}

}  // namespace ringsplat::fuzz
