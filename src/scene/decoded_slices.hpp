#pragma once
#include <functional>
#include <map>

#include "net/collectives.hpp"
#include "ringsplat/volume/source.hpp"

namespace ringsplat {

/// The z slices of a volume that this process has decoded for others and itself, group by group.
///
/// A group has one span of slices for each process that reads: whole layers, as few as make a batch. So every
/// layer is decoded by one process, once. A process holds one span, and of the group before it the slices
/// that are still needed.
class DecodedSlices {
 public:
  /// `source` may be null on a process that does not read, one whose number is not below `readers`. `batch`:
  /// slices that a group should have at least.
  DecodedSlices(VolumeSource* source, const Grid& grid, int layer_depth, int process, int readers, int batch);

  /// Slices before end() have been decoded by their readers.
  int end() const { return end_; }
  /// Forgets slices before `needed` and decodes this process's span of the next group. Calls `told(z)` with
  /// how far all readers are by now, if each is as fast as this one. Throws InputError.
  void decode_group(int needed, const std::function<void(double z)>& told);
  /// A slice, when this process holds it; else null.
  const std::byte* find(int z) const;

 private:
  struct Run {
    int count = 0;
    Block voxels;
  };
  void forget_before(int z);

  VolumeSource* source_;
  int slices_, depth_, process_, span_, group_, end_ = 0;
  std::size_t slice_bytes_;
  std::map<int, Run> runs_;  ///< by their first slice
};

}  // namespace ringsplat
