#pragma once
#include <array>
#include <optional>
#include <string>

#include "ringsplat/volume/voxel_box.hpp"

namespace ringsplat::app {

/// A clip box as people type it, "x0:x1,y0:y1,z0:z1": a part that is empty or has an open end reaches to the
/// volume's face. Numbers are voxels, x0 the first and x1 the first behind; in a part that ends in "mm", and
/// in all parts when the last one does, they are distances from the volume's first face along the lattice's
/// axis, in the file's world units, and voxels count whose centres lie between.
struct ClipText {
  struct Part {
    std::string text;  ///< as typed, for messages
    std::optional<double> first, end;
    bool distances = false;
    bool operator==(const Part&) const = default;
  };
  std::string option;  ///< for messages
  std::array<Part, 3> parts;
  bool operator==(const ClipText&) const = default;
};

/// Throws InputError that names the part that is no range.
ClipText parse_clip(const std::string& text, const std::string& option);

/// The voxels that are meant. Throws InputError that names the part that has none or leaves the volume.
VoxelBox clip_box(const ClipText& clip, const Grid& grid);

/// The same of a text that may be missing.
std::optional<VoxelBox> clip_box(const std::optional<ClipText>& clip, const Grid& grid);

}  // namespace ringsplat::app
