#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "ringsplat/volume/voxel_box.hpp"
#include "sheet_engine/place_map.hpp"
#include "sheet_engine/sheet_payload.hpp"

namespace ringsplat {

/// Which blocks of a GP's slices Renderers hold on one shelf.
class KeptShelf {
 public:
  /// `planes` of all GPs together; this one has each `gps`-th from its own number on.
  KeptShelf(int slices, int blocks, int renderers, int planes, int gp, int gps);
  /// The number of the plane that Renderers keep a slice in; the first slices that ask get one.
  std::uint16_t plane_of(int slice);
  /// By block of a slice: whether the Renderer holds its voxels.
  std::vector<bool>& held(int slice, int renderer);

 private:
  int blocks_, renderers_, planes_, next_, gps_;
  std::vector<std::uint16_t> plane_of_;  ///< by slice
  /// By slice, Renderer and block; empty until it is asked for, as those of other GPs' slices stay.
  std::vector<std::vector<std::vector<bool>>> held_;
};

/// What a GP lets the Renderers keep. Scalars do not depend on the view: a Renderer that has been sent a
/// block can draw it again, from wherever it is seen. The GPs alone decide, each by the frames that all of
/// them are told, so they agree without a message, and a Renderer draws payloads in the order of their
/// frames; so what was sent is there.
class KeptBlocks {
 public:
  /// `limit`: bytes of planes on each Renderer.
  KeptBlocks(int gp, int gps, int renderers, std::uint64_t limit)
      : gp_(gp), gps_(gps), renderers_(renderers), limit_(limit) {}

  struct OfFrame {
    ShelfNumber number;
    std::shared_ptr<KeptShelf> shelf;  ///< null: nothing is kept
  };
  /// Takes frames in ascending order. Frees the shelves that were not used for longest where one is new.
  OfFrame begin_frame(const SheetFrame& frame, const ValueScale& scale);

 private:
  /// What planes hold numbers of.
  struct Sort {
    Axis axis = Axis::z;
    VoxelBox box;
    int factor = 1;
    PlaneCode code;
    bool operator==(const Sort&) const = default;
  };
  struct Shelf {
    Sort sort;
    std::uint64_t bytes = 0;
    std::int64_t used = -1;  ///< the last frame that used it; free without `blocks`
    std::uint16_t generation = 0;
    std::shared_ptr<KeptShelf> blocks;
  };

  void free_for(std::uint64_t bytes);
  std::uint8_t live() const;

  int gp_, gps_, renderers_;
  std::uint64_t limit_;
  std::array<Shelf, ShelfNumber::shelves> shelves_;
};

}  // namespace ringsplat
