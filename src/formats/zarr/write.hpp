#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "ringsplat/volume/source.hpp"
#include "ringsplat/volume/voxel_box.hpp"

namespace ringsplat {

/// A level of an OME-Zarr image that is being written: an array of Zarr 2 in chunks that blosc compresses.
/// Layers, the slices of a row of chunks, are written whole or block by block, by several processes at once.
class ZarrLevel {
 public:
  /// Nothing is written yet.
  ZarrLevel(std::filesystem::path folder, const Grid& grid);

  int layers() const { return (grid_.dims.z + chunk_.z - 1) / chunk_.z; }
  const std::filesystem::path& folder() const { return folder_; }
  int layer_depth() const { return chunk_.z; }
  /// Blocks of all slices that together are the level: each of whole chunks along x and y, and as large as it
  /// can be with at most so many bytes a slice, or one chunk wide.
  std::vector<VoxelBox> blocks(double slice_bytes) const;
  /// Makes the folder and says in it what the array is. One process does so before the others write. Throws
  /// RunError.
  void begin() const;
  /// True when all chunks of the layer's part in the block are on the disk.
  bool has_layer(int layer, const VoxelBox& block) const;
  /// Reads the layer's slices of the block, which is all that `source` has, and writes their chunks, each
  /// under its name only when it is whole. Throws RunError when the disk is full or fails.
  void write_layer(int layer, const VoxelBox& block, VolumeSource& source) const;

 private:
  std::filesystem::path chunk_file(int layer, int row, int column) const {
    return folder_ / std::to_string(layer) / std::to_string(row) / std::to_string(column);
  }
  /// Of a layer's slices of a block of this grid, filled up with zeros beyond the volume's far faces, as
  /// chunks are all of one size. `x`, `y`: in the block.
  std::vector<std::byte> chunk_of(std::span<const std::byte> slices, const Grid& block, int y, int x) const;

  std::filesystem::path folder_;
  Grid grid_;
  /// 64 voxels along each axis; thinner and wider where slices are large, so that a layer takes 64 MiB or
  /// little more than a slice.
  glm::ivec3 chunk_;
};

/// Makes a folder with the levels "0", "1", ... an image of OME-Zarr 0.4. What OME-Zarr has no words for is
/// said in the image's metadata, from which open_volume() gives back the lattice in the world and `notes` as
/// they were; channels, time points and series are not among them. Throws RunError.
void write_ome_zarr(const std::filesystem::path& store, const std::vector<Grid>& levels,
                    const VolumeNotes& notes);

}  // namespace ringsplat
