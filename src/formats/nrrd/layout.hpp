#pragma once
#include <NrrdIO.h>  // has no guard: nothing that includes this header may include it, too

#include <cstdint>
#include <filesystem>
#include <optional>

#include "ringsplat/volume/grid.hpp"

namespace ringsplat::detail {

/// An NRRD's axes of which not all are the lattice's: one may come before the lattice's (its numbers are a
/// voxel's), others behind (whole volumes follow each other).
struct NrrdLayout {
  enum class Axis { none, frames, channels };

  Grid grid;        ///< in left-posterior-superior where the header tells the patient's axes
  int leading = 1;  ///< numbers in a voxel
  Axis leading_is = Axis::none;
  int frames = 1, channels = 1;                        ///< of all axes
  std::uint64_t frame_stride = 0, channel_stride = 0;  ///< of axes behind, in volumes
  std::uint64_t volumes = 1;                           ///< of all axes behind
  bool colours = false;                                ///< the leading axis is of red, green, blue and alpha
};

/// The grid of an NRRD whose axes are all the lattice's.
Grid nrrd_grid(const Nrrd& nrrd, const std::filesystem::path& path);

/// Nothing when all axes are the lattice's, which are at most three. Axes that are not: those without a
/// direction where the header has a space, those of a kind that is no domain, the last beyond three. A kind
/// of vector or colour is of channels, any other (time, list, none) of frames. Throws InputError for axes of
/// neither, between the lattice's, or several of one role.
std::optional<NrrdLayout> nrrd_layout(const Nrrd& nrrd, const std::filesystem::path& path);

}  // namespace ringsplat::detail
