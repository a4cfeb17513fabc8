#include "splat_engine/encoder_frame.hpp"

#include <cmath>
#include <glm/common.hpp>

#include "raster/opaque_news.hpp"

namespace ringsplat {

namespace {

/// Of a voxel that stands for `weight` of its slice, a lattice of them within its cell.
KernelReach beyond_voxel_of(const FrameGeometry& g, double weight) {
  if (weight <= 1) return {0, 0};
  const auto [u, v] = in_plane(g.traversal.axis);
  const glm::dvec2 cell = glm::abs(glm::dvec2(g.view.linear[u])) + glm::abs(glm::dvec2(g.view.linear[v])),
                   beyond = 0.5 * (1 - 1 / std::sqrt(weight)) * cell;
  return {std::llround(beyond.x), std::llround(beyond.y)};
}

}  // namespace

EncoderFrame::EncoderFrame(const SplatFrame& splat_frame, bool count)
    : frame(splat_frame),
      geometry(frame.geometry),
      shading(frame.shown, geometry),
      reach(kernel_reach(frame.footprint)),
      stride(pass_stride(frame.splats.kernel_radius)),
      count_pixels(count),
      beyond_voxel(beyond_voxel_of(geometry, frame.voxel_weight)),
      covers(std::size_t(geometry.regions.count())) {
  opaque.reserve(covers.size());
  rects.reserve(covers.size());
  for (int region = 0; region < geometry.regions.count(); ++region) {
    rects.push_back(geometry.regions.rect(region));
    opaque.emplace_back(rects.back().width(), rects.back().height());
  }
}

void EncoderFrame::take_opaque_news(std::span<const std::byte> news) {
  if (news.empty()) return;
  read_opaque_news(news, opaque);
  for (std::size_t region = 0; region < covers.size(); ++region)
    if (covers[region].opaque() != opaque[region].opaque()) covers[region].update(opaque[region]);
}

}  // namespace ringsplat
