#include "engine_parts/owned_images.hpp"

#include <utility>

#include "net/message.hpp"
#include "raster/opaque_tiles.hpp"

namespace ringsplat {

void OwnedImages::begin_frame(const FrameGeometry& g, double opaque_threshold) {
  RegionOwners owners = g.owners(renderers_);
  if (!(regions_ == g.regions && owners_ == owners)) {
    regions_ = g.regions;
    owners_ = std::move(owners);
    images_.clear();
    slot_of_region_.assign(std::size_t(regions_.count()), not_owned);
    owned_ = regions_.owned(renderer_, owners_);
    for (const int region : owned_) {
      slot_of_region_[std::size_t(region)] = images_.size();
      images_.emplace_back(regions_.rect(region));
    }
  }
  for (RegionImage& image : images_) image.begin_frame(static_cast<float>(opaque_threshold));
  told_.clear();
}

void OwnedImages::news(int gp, Bytes& news) {
  if (images_.empty()) return;
  auto& told = told_[gp];
  told.resize(images_.size(), 0);
  for (std::size_t k = 0; k < images_.size(); ++k) {
    const OpaqueTiles& tiles = images_[k].opaque_tiles();
    if (tiles.opaque() == std::exchange(told[k], tiles.opaque())) continue;
    if (news.empty()) news = Message::body_buffer();
    append_opaque_news(owned_[k], tiles, news);
  }
}

void OwnedImages::deliver(const std::function<void(int, Bytes)>& deliver) const {
  for (std::size_t k = 0; k < images_.size(); ++k) {
    if (!images_[k].touched()) continue;
    const PixelRect& rect = images_[k].rect();
    const std::size_t floats = std::size_t(4) * std::size_t(rect.width()) * std::size_t(rect.height());
    Bytes body(sizeof(Header) + floats * sizeof(float));
    images_[k].read_tile({reinterpret_cast<float*>(body.data() + sizeof(Header)), floats});
    deliver(owned_[k], std::move(body));
  }
}

}  // namespace ringsplat
