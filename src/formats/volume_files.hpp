#pragma once
#include <algorithm>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/input_file.hpp"
#include "ringsplat/base/fact.hpp"
#include "ringsplat/volume/source.hpp"
#include "ringsplat/volume/voxel_box.hpp"

namespace ringsplat::detail {

/// `count` names, in which the numbers `first`, `first` + `step`, ... stand for the "%d" or "%03d" of a
/// pattern; none when it is no such pattern. Headers come from anywhere: nothing else may follow a percent
/// sign.
std::vector<std::string> numbered_names(const std::string& pattern, std::int64_t first, std::int64_t count,
                                        std::int64_t step);

/// The files of a volume, as they were when this was made.
class VolumeFiles {
 public:
  /// `files`: in the order of the slices; a file several times in a row counts once. Throws InputError when
  /// one cannot be read.
  explicit VolumeFiles(const std::vector<std::filesystem::path>& files);
  /// Throws InputError when the file has changed or is gone. Call it before a file is opened again and after
  /// it was read.
  void require_unchanged(const std::filesystem::path& file) const;
  /// Sizes, and hashes of the first and the last bytes; of several files their number and their names without
  /// folders, too.
  Facts facts() const;
  /// The same of an only file, with hashes of the `bytes` bytes from `offset` on.
  Facts facts(std::uint64_t offset, std::uint64_t bytes) const;

 private:
  std::vector<std::filesystem::path> files_;
  std::unordered_map<std::string, FileStamp> stamps_;  ///< by path
};

/// A volume of files that is read in layers: slices that are decoded together, or one by one. Reads that are
/// not whole layers keep the last one.
class LayeredSource : public VolumeSource {
 public:
  /// `concurrent`: every process reads its own layers. `encoding`: facts beside the grid's and the files'.
  LayeredSource(const Grid& grid, const std::vector<std::filesystem::path>& files, Facts encoding,
                bool concurrent = true)
      : grid_(grid), files_(files), encoding_(std::move(encoding)), concurrent_(concurrent) {}
  const Grid& grid() const final { return grid_; }
  bool concurrent() const final { return concurrent_; }
  int layer_depth() const final { return depth_; }
  void read_slices(int first, int count, std::span<std::byte> out) final;
  Facts facts() const final {
    Facts facts = encoding_;
    std::ranges::copy(files_.facts(), std::back_inserter(facts));
    return facts;
  }

 protected:
  /// `slices`: that are decoded together, as of a chunk. Layers of more than 256 MiB are cut into thinner
  /// ones, as even as they can be, which keeps memory bounded and decodes chunks once for each of them.
  void set_layer(std::uint64_t slices) {
    constexpr std::uint64_t most_bytes = std::uint64_t{256} << 20;
    const auto depth = std::min<std::uint64_t>(slices, std::uint64_t(grid_.dims.z));
    const std::uint64_t most = std::max<std::uint64_t>(1, most_bytes / grid_.slice_bytes(Axis::z));
    const std::uint64_t parts = (depth + most - 1) / most;
    depth_ = int((depth + parts - 1) / parts);
  }
  /// Throws InputError when a file is no longer what it was when the volume was opened.
  void require_unchanged(const std::filesystem::path& file) const { files_.require_unchanged(file); }

 private:
  /// Slices [begin, end), which are one layer.
  virtual void read_layer(int begin, int end, std::span<std::byte> out) = 0;

  Grid grid_;
  VolumeFiles files_;
  Facts encoding_;
  bool concurrent_;
  int depth_ = 1;
  std::vector<std::byte> kept_;  ///< the last layer that was not read as a whole
  int kept_first_ = -1;
};

inline constexpr const char* piece_hint = "write all pieces again, from one volume";
inline constexpr std::size_t most_pieces = 1 << 16;  ///< each is compared with those beside it

/// A box of a volume's voxels, which a source of its own holds, and maybe others around them.
struct VolumePiece {
  std::filesystem::path file;
  VoxelBox box = {};                                         ///< which lies in the volume and is not empty
  glm::ivec3 from{0};                                        ///< where the source's first voxel lies there
  std::function<std::unique_ptr<VolumeSource>()> open = {};  ///< of the volume's type, spacing and origin
};

/// The volume that pieces fill. All are opened once, so that a missing or damaged one is an InputError at
/// once, and so are pieces that overlap or leave gaps; later only those that a slice goes through. `where`:
/// for messages.
std::unique_ptr<VolumeSource> pieced_source(const Grid& grid, std::vector<VolumePiece> pieces,
                                            const std::string& where);

}  // namespace ringsplat::detail
