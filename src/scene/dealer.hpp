#pragma once
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "net/collectives.hpp"
#include "ringsplat/volume/reduced.hpp"
#include "ringsplat/volume/strides.hpp"
#include "ringsplat/volume/voxel_box.hpp"
#include "scene/scene.hpp"
#include "volume/slice_store.hpp"

namespace ringsplat {

/// Bytes of z slices sent in one round, over all processes.
inline constexpr std::size_t batch_bytes = std::size_t{8} << 20;

/// Slices of a round.
int batch_of(const Grid& grid);

/// Where the z slices of a volume that is dealt come from, batch by batch in ascending order.
class SliceSupply {
 public:
  /// True when a process needs a slice for the batch.
  using Needed = std::function<bool(int process, int z)>;

  virtual ~SliceSupply() = default;
  /// Makes slices from z on available, and those beside them. Returns their end, above z. Collective; all
  /// processes throw the same InputError when one cannot read.
  virtual int available_from(int z) = 0;
  /// Gives every process the slices among [first, end) that it needs; those of earlier batches are forgotten.
  /// Collective.
  virtual void hand_out(int first, int end, const Needed& needed) = 0;
  /// One that this process needs for the batch. Throws InputError when it cannot be read.
  virtual const std::byte* slice(int z) = 0;
};

/// The slices that GPs have, all of which must keep z slices; or those of the reduced volume. `stores` must
/// outlive the supply.
std::unique_ptr<SliceSupply> stored_supply(const Grid& grid, const std::map<int, SliceStore>& stores,
                                           const Reduction& reduction, const Sharing& sharing);

/// What a deal makes of its slices, for whom.
struct Deal {
  const LoadOptions& options;  ///< of a single level
  const Sharing& sharing;
  /// This process's stores of the same volume, whose values are taken over; null: none.
  const std::map<int, SliceStore>* known = nullptr;
  /// Called with the end of the slices that are dealt.
  std::function<void(int end)> dealt = {};
};

/// Gives GPs the slices of the kept axes. Returns this process's stores by GP.
std::map<int, SliceStore> deal_slices(const Grid& grid, SliceSupply& supply, const Deal& deal);

/// A part of a volume in memory.
struct VoxelBlock {
  VoxelBox extent;
  const std::byte* first_voxel = nullptr;  ///< that of extent.first
  Strides strides;
};

/// Throws InputError on all processes when a process's blocks are wrong in themselves (not within the grid, a
/// null pointer), or all blocks together do not cover the grid once. Collective.
void check_blocks(const Grid& grid, const std::vector<VoxelBlock>& mine, Collectives& collectives);

/// Copies the voxels of all processes' blocks into the z slices of the GPs that own them. Blocks cover the
/// grid once. In rounds of one process to another, or to several: a process sends and receives at most
/// `round_bytes`, or one row of voxels, at a time. Collective.
void deal_blocks(const Grid& grid, const std::vector<VoxelBlock>& mine, std::map<int, SliceStore>& stores,
                 std::size_t round_bytes, const Sharing& sharing);

/// The same to a process whose call takes no part: all that this process has for it, for place_blocks()
/// there, behind `before` bytes that are left to the caller. Not collective.
Block packed_blocks(const Grid& grid, const std::vector<VoxelBlock>& mine, int process,
                    const Sharing& sharing, std::size_t before);
void place_blocks(const Grid& grid, std::span<const std::byte> packed, std::map<int, SliceStore>& stores,
                  const Sharing& sharing);

/// A block in its volume, with the process that has it.
struct PlacedBlock {
  VoxelBox extent;
  int process = 0, number = 0;  ///< its number on that process
};

/// Throws InputError that names a hole, or two blocks that overlap and where, unless the blocks cover every
/// voxel of the box exactly once. Each block meets the box.
void check_cover(const VoxelBox& box, const std::vector<PlacedBlock>& blocks);

}  // namespace ringsplat
