#pragma once
#include <functional>
#include <map>
#include <vector>

#include "frame/frame_geometry.hpp"
#include "raster/region_image.hpp"
#include "ringsplat/base/bytes.hpp"

namespace ringsplat {

/// The images of the regions that one Renderer owns in a frame, and what GPs were told of their opaque tiles.
class OwnedImages {
 public:
  OwnedImages(int renderer, int renderers) : renderer_(renderer), renderers_(renderers) {}

  /// Clears all images; their memory stays while the regions do.
  void begin_frame(const FrameGeometry& geometry, double opaque_threshold);

  std::size_t count() const { return images_.size(); }
  RegionImage& image(std::size_t slot) { return images_[slot]; }
  const RegionImage& image(std::size_t slot) const { return images_[slot]; }
  bool owns(int region) const {
    return region >= 0 && std::size_t(region) < slot_of_region_.size() &&
           slot_of_region_[std::size_t(region)] != not_owned;
  }
  const std::vector<int>& owned() const { return owned_; }  ///< ascending, by their images
  /// Index of an owned region's image.
  std::size_t slot_of(int region) const { return slot_of_region_[std::size_t(region)]; }

  /// Appends to `news` the opaque tiles that GP `gp` has not been told of (Painter::news).
  void news(int gp, Bytes& news);
  /// Hands over the tiles that are not empty (Painter::finish).
  void deliver(const std::function<void(int tile, Bytes bytes)>& deliver) const;

 private:
  static constexpr std::size_t not_owned = ~std::size_t{0};

  int renderer_, renderers_;
  Regions regions_;
  RegionOwners owners_;
  std::vector<int> owned_;                   ///< regions
  std::vector<RegionImage> images_;          ///< one for each owned region
  std::vector<std::size_t> slot_of_region_;  ///< into images_
  std::map<int, std::vector<int>> told_;     ///< by GP: for each owned region, the opaque tiles it knows of
};

}  // namespace ringsplat
