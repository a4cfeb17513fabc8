#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "ringsplat/volume/source.hpp"
#include "ringsplat/volume/voxel_box.hpp"

namespace ringsplat {

/// The command line's description of a raw file; missing fields come from its name
/// (`name_256x256x128_uint8.raw`).
struct RawDescription {
  std::optional<glm::ivec3> dims;
  std::optional<ScalarType> type;
  std::optional<bool> big_endian;
  std::optional<std::uint64_t> offset;  ///< bytes before the first voxel
  std::optional<glm::dvec3> spacing;
  bool empty() const { return !dims && !type && !big_endian && !offset && !spacing; }
};

/// Which of the volumes in a file or a folder to take.
struct VolumeChoice {
  std::optional<int> frame = std::nullopt;  ///< the time point, from 0; without it the first
  /// A number from 0, r, g, b or a, or a channel's name; "all": the first, for whoever takes each in turn;
  /// empty: not chosen.
  std::string channel = {};
  std::string series = {};  ///< of a DICOM folder; empty: not chosen
  /// Bytes that the voxels may take, for which a level of an OME-Zarr pyramid is chosen; without it a third
  /// of this machine's memory.
  std::optional<double> memory = std::nullopt;
  int volumes = 1;       ///< that share that memory, where it is not given
  bool coarser = false;  ///< the next coarser level, where there is one
  /// The part of a lattice that is read, as if the file held no more; empty: all. A level of a pyramid is
  /// chosen for that part, which is asked for in voxels of the finest.
  std::function<VoxelBox(const Grid&)> crop = {};
};

/// Opens a file or a folder of one of the formats in docs/volumes.md, by its ending or its first bytes, or a
/// raw file. "file.h5:/path/to/dataset" names one of an HDF5 file's datasets. For files that describe
/// themselves only `raw.spacing` may be given; it replaces theirs.
///
/// World coordinates are a patient's as ITK has them (left, posterior, superior), a microscope's, or the
/// file's x, y and z; docs/volumes.md has which.
///
/// Whole slices are decoded one after another, without holding the volume, except for the frames of a
/// multi-frame DICOM file.
///
/// Checks that the file is as long as its header says before anything is allocated. Throws InputError: what
/// is wrong, in which file and field, what to do.
std::unique_ptr<VolumeSource> open_volume(const std::filesystem::path& path, const RawDescription& raw = {},
                                          const VolumeChoice& choice = {});

}  // namespace ringsplat
