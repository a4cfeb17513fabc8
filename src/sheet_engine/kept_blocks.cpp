#include "sheet_engine/kept_blocks.hpp"

#include "sheet_engine/scalar_planes.hpp"
#include "volume/cell_ranges.hpp"

namespace ringsplat {

KeptShelf::KeptShelf(int slices, int blocks, int renderers, int planes, int gp, int gps)
    : blocks_(blocks),
      renderers_(renderers),
      planes_(planes),
      next_(gp),
      gps_(gps),
      plane_of_(std::size_t(slices), no_plane),
      held_(std::size_t(slices)) {}

std::uint16_t KeptShelf::plane_of(int slice) {
  std::uint16_t& plane = plane_of_[std::size_t(slice)];
  if (plane == no_plane && next_ < planes_) {
    plane = std::uint16_t(next_);
    next_ += gps_;
  }
  return plane;
}

std::vector<bool>& KeptShelf::held(int slice, int renderer) {
  auto& of_slice = held_[std::size_t(slice)];
  if (of_slice.empty()) of_slice.assign(std::size_t(renderers_), std::vector<bool>(std::size_t(blocks_)));
  return of_slice[std::size_t(renderer)];
}

KeptBlocks::OfFrame KeptBlocks::begin_frame(const SheetFrame& frame, const ValueScale& scale) {
  const FrameGeometry& geometry = frame.geometry;
  const Axis axis = geometry.traversal.axis;
  const Sort sort{axis, geometry.box, frame.shown.reduction.factor, scale.code};
  auto shelf = std::find_if(shelves_.begin(), shelves_.end(),
                            [&](const Shelf& s) { return s.blocks != nullptr && s.sort == sort; });
  if (shelf == shelves_.end()) {
    const int width = geometry.grid.slice_width(axis), height = geometry.grid.slice_height(axis);
    const std::uint64_t plane = plane_bytes(width, height, scale.code);
    const auto planes =
        int(std::min({std::uint64_t(geometry.slices), limit_ / plane, std::uint64_t(no_plane)}));
    if (planes == 0) return {{.live = live()}, nullptr};
    free_for(std::uint64_t(planes) * plane);
    shelf = std::ranges::find_if(shelves_, [](const Shelf& s) { return s.blocks == nullptr; });
    const int blocks = CellRanges::blocks_along(width) * CellRanges::blocks_along(height);
    *shelf = {sort, std::uint64_t(planes) * plane, frame.number, std::uint16_t(shelf->generation + 1),
              std::make_shared<KeptShelf>(geometry.slices, blocks, renderers_, planes, gp_, gps_)};
  }
  shelf->used = frame.number;
  return {{std::uint8_t(shelf - shelves_.begin()), live(), shelf->generation}, shelf->blocks};
}

/// Frees shelves until one is free and there is memory for `bytes`.
void KeptBlocks::free_for(std::uint64_t bytes) {
  for (;;) {
    std::uint64_t taken = 0;
    std::size_t in_use = 0;
    Shelf* oldest = nullptr;
    for (Shelf& shelf : shelves_) {
      if (shelf.blocks == nullptr) continue;
      ++in_use;
      taken += shelf.bytes;
      if (oldest == nullptr || shelf.used < oldest->used) oldest = &shelf;
    }
    if (oldest == nullptr || (in_use < shelves_.size() && taken + bytes <= limit_)) return;
    oldest->blocks = nullptr;
  }
}

std::uint8_t KeptBlocks::live() const {
  std::uint8_t bits = 0;
  for (std::size_t k = 0; k < shelves_.size(); ++k)
    if (shelves_[k].blocks != nullptr) bits |= std::uint8_t(1U << k);
  return bits;
}

}  // namespace ringsplat
