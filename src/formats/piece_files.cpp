#include "formats/piece_files.hpp"

#include <algorithm>
#include <utility>

#include "formats/volume_files.hpp"

namespace ringsplat::detail {
namespace {

/// The grid of one of `count` files.
Grid piece_of(const Grid& grid, std::size_t count) {
  const auto voxels = grid.voxels() / std::int64_t(count);
  const auto slice = std::int64_t(grid.slice_voxels(Axis::z));
  Grid piece = grid;
  if (voxels % slice == 0)
    piece.dims.z = int(voxels / slice);
  else if (voxels % grid.dims.x == 0)
    piece.dims = {grid.dims.x, int(voxels / grid.dims.x), 1};
  else
    piece.dims = {int(voxels), 1, 1};
  return piece;
}

class PieceFilesSource final : public VolumeSource {
 public:
  PieceFilesSource(const Grid& grid, std::vector<std::filesystem::path> files, OpenPiece open)
      : grid_(grid),
        piece_(piece_of(grid, files.size())),
        paths_(std::move(files)),
        files_(paths_),
        open_(std::move(open)) {
    for (const auto& path : paths_) kept_ = open_(piece_, path);
    concurrent_ = kept_->concurrent();
    facts_ = kept_->facts();
    kept_.reset();
  }

  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return concurrent_; }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto bytes = piece_.bytes(), slice = std::uint64_t(piece_.slice_bytes(Axis::z));
    auto position = std::uint64_t(first) * grid_.slice_bytes(Axis::z);
    out = out.first(std::size_t(count) * grid_.slice_bytes(Axis::z));
    while (!out.empty()) {
      const auto number = std::size_t(position / bytes);
      const auto within = position % bytes;
      const auto part = std::size_t(std::min<std::uint64_t>(out.size(), bytes - within));
      const auto own = concurrent_ ? opened(number) : nullptr;
      auto& source = own ? *own : kept(number);
      source.read_slices(int(within / slice), int(part / slice), out.first(part));
      position += part;
      out = out.subspan(part);
    }
  }

  Facts facts() const override {
    Facts facts = facts_;
    const Facts of_files = files_.facts();
    facts.insert(facts.end(), of_files.begin(), of_files.end());
    return facts;
  }

 private:
  std::unique_ptr<VolumeSource> opened(std::size_t number) const {
    files_.require_unchanged(paths_[number]);
    return open_(piece_, paths_[number]);
  }
  /// Files that are decoded in order stay open from one read to the next.
  VolumeSource& kept(std::size_t number) {
    if (!kept_ || number_ != number) {
      kept_.reset();
      kept_ = opened(number);
      number_ = number;
    }
    return *kept_;
  }

  Grid grid_, piece_;
  std::vector<std::filesystem::path> paths_;
  VolumeFiles files_;
  OpenPiece open_;
  bool concurrent_ = false;
  Facts facts_;                         ///< of the last file
  std::unique_ptr<VolumeSource> kept_;  ///< of file `number_`, when there is one
  std::size_t number_ = 0;
};

}  // namespace

std::unique_ptr<VolumeSource> piece_files_source(const Grid& grid, std::vector<std::filesystem::path> files,
                                                 OpenPiece open) {
  return std::make_unique<PieceFilesSource>(grid, std::move(files), std::move(open));
}

}  // namespace ringsplat::detail
