#include "splat_engine/encoder_frame.hpp"

#include "raster/opaque_news.hpp"

namespace ringsplat {

EncoderFrame::EncoderFrame(const FrameSpec& frame_spec, const FrameGeometry& frame_geometry)
    : spec(frame_spec),
      geometry(frame_geometry),
      shading(frame_spec, frame_geometry),
      reach(kernel_reach(frame_geometry.footprint)),
      stride(pass_stride(frame_spec.kernel_radius)),
      covers(std::size_t(frame_geometry.regions.count())) {
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
