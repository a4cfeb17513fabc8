#pragma once
// Small scenes and one-line rendering for tests.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "session/render_frames.hpp"
#include "support/memory_source.hpp"
#include "volume/forwarding_source.hpp"
#include "volume/synth.hpp"

namespace ringsplat::test {

inline Grid make_grid(glm::ivec3 dims, ScalarType type = ScalarType::uint8,
                      glm::dvec3 spacing = glm::dvec3(1.0)) {
  Grid grid;
  grid.dims = dims;
  grid.type = type;
  grid.spacing = spacing;
  return grid;
}

/// White, with the same opacity for every value from `from` up, none below.
inline TransferFunction constant_opacity(double opacity, double from = -1e300) {
  TransferFunction tf;
  tf.colours = {{0.0, {1, 1, 1}}, {1.0, {1, 1, 1}}};
  if (from > -1e300)
    tf.opacities = {{from, 0.0}, {from, opacity}};
  else
    tf.opacities = {{0.0, opacity}, {1.0, opacity}};
  return tf;
}

/// A warm ramp over [low, high], transparent below `low`.
inline TransferFunction ramp(double low, double high, double opacity) {
  TransferFunction tf;
  tf.colours = {{low, {0.9, 0.4, 0.2}}, {high, {0.6, 0.8, 1.0}}};
  tf.opacities = {{low, 0.0}, {high, opacity}};
  return tf;
}

/// Renders a director's frames with all ranks in this process.
inline void render_directed(VolumeSource& source, const LoadOptions& load, const Layout& layout,
                            Director director, const LoopbackOptions& loopback = {},
                            const ProtocolOptions& protocol = {}, const EngineOptions& engine = {}) {
  SoloCollectives solo;
  const Wiring wiring{solo, nullptr, loopback};
  OpenedVolume volume{source.grid(), source.concurrent(), std::make_unique<ForwardingSource>(source)};
  volume.has_labels = source.labels() != nullptr;
  Scene scene = load_scene(volume, load, layout, wiring);
  render_frames(std::move(scene), layout, protocol, std::move(director), wiring, engine);
}

/// Renders one frame with all ranks in this process.
inline FrameResult render_loopback(VolumeSource& source, const FrameSpec& spec, const Layout& layout,
                                   const LoopbackOptions& loopback = {}, const ProtocolOptions& protocol = {},
                                   const EngineOptions& engine = {}) {
  FrameResult result;
  const auto keep = [&result](FrameResult&& r) { result = std::move(r); };
  render_directed(source, needed_to_render(spec, source.grid()), layout, director_of({spec}, keep), loopback,
                  protocol, engine);
  return result;
}

inline FrameResult render_loopback(VolumeSource& source, const FrameSpec& spec, int gps, int renderers,
                                   const LoopbackOptions& loopback = {},
                                   Placement placement = Placement::dedicated,
                                   const ProtocolOptions& protocol = {}, const EngineOptions& engine = {}) {
  return render_loopback(source, spec, Layout{gps, renderers, placement}, loopback, protocol, engine);
}

/// One image of a volume in memory. `voxels` (grid.bytes() bytes, native order) is read on process 0 only and
/// is dealt to the GPs as if it decoded a file; the others may pass an empty span. The image is process 0's.
inline Image render_image(const Grid& grid, std::span<const std::byte> voxels, const FrameSpec& spec,
                          const Layout& layout, const Wiring& wiring, const EngineOptions& engine = {}) {
  OpenedVolume volume{grid, false, nullptr};
  if (wiring.collectives.process() == 0) volume.source = memory_source(grid, voxels);
  Scene scene = load_scene(volume, needed_to_render(spec, grid), layout, wiring);
  Image image;
  const auto keep = [&image](FrameResult&& result) { image = std::move(result.image); };
  render_frames(std::move(scene), layout, {}, director_of({spec}, keep), wiring, engine);
  return image;
}

inline float brightest(const Image& image) { return *std::max_element(image.rgba.begin(), image.rgba.end()); }

inline double largest_difference(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height) return 1e300;
  double largest = 0;
  for (std::size_t k = 0; k < a.rgba.size(); ++k)
    largest = std::max(largest, double(std::abs(a.rgba[k] - b.rgba[k])));
  return largest;
}

}  // namespace ringsplat::test
