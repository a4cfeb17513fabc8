#include "splat_engine/encoder_frame.hpp"

#include "raster/opaque_tiles.hpp"

namespace ringsplat {

EncoderFrame::EncoderFrame(const SplatFrame& splat_frame)
    : frame(splat_frame),
      geometry(frame.geometry),
      shading(frame.shown, geometry),
      reach(kernel_reach(frame.footprint)),
      stride(pass_stride(frame.splats.kernel_radius)),
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
