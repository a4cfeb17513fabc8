#pragma once
#include <cstdint>

#include "formats/nrrd/header.hpp"
#include "ringsplat/volume/grid.hpp"

namespace ringsplat::detail {

/// What an NRRD's axes are: at most three are the lattice's, one may come before these (its numbers are a
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

/// Axes that are not the lattice's: those without a direction where the header has a space, those of a kind
/// that is no domain, the last beyond three. A kind of vector or colour is of channels, any other (time,
/// list, none) of frames. Throws InputError for axes of neither, between the lattice's, or several of one
/// role.
NrrdLayout nrrd_layout(const NrrdHeader& header);

}  // namespace ringsplat::detail
