#include "formats/pieces.hpp"

#include <algorithm>
#include <cstring>
#include <glm/vector_relational.hpp>
#include <map>
#include <utility>

#include "formats/limits.hpp"
#include "formats/volume_files.hpp"

namespace ringsplat::detail {
namespace {

constexpr const char* hint = "write all pieces again, from one volume";

bool overlap(const VolumePiece& a, const VolumePiece& b) {
  return glm::all(glm::lessThan(a.first, b.end)) && glm::all(glm::lessThan(b.first, a.end));
}

/// `pieces`: sorted along z.
void require_full(const Grid& grid, const std::vector<VolumePiece>& pieces, const std::string& where) {
  constexpr std::size_t most = 1 << 16;  // each is compared with those beside it
  if (pieces.size() > most) refuse(where, "write fewer of them", "it has {} pieces", pieces.size());
  std::int64_t held = 0;
  for (auto piece = pieces.begin(); piece != pieces.end(); ++piece) {
    const auto size = piece->end - piece->first;
    held += std::int64_t{size.x} * size.y * size.z;
    for (auto other = piece + 1; other != pieces.end() && other->first.z < piece->end.z; ++other)
      if (overlap(*piece, *other))
        refuse(where, hint, "the pieces {} and {} overlap", piece->file.string(), other->file.string());
  }
  if (held != grid.voxels())
    refuse(where, hint, "its pieces leave a gap: they hold {} of {} voxels", held, grid.voxels());
}

class PiecedSource final : public LayeredSource {
 public:
  PiecedSource(const Grid& grid, std::vector<VolumePiece> pieces, bool concurrent)
      : LayeredSource(grid, files_of(pieces), {{"encoding", "pieces"}}, concurrent),
        pieces_(std::move(pieces)) {}

 private:
  void read_layer(int z, int, std::span<std::byte> out) override {
    const auto size = size_of(grid().type), row = std::size_t(grid().dims.x) * size;
    for (const auto& piece : pieces_) {
      if (z < piece.first.z || z >= piece.end.z) continue;
      require_unchanged(piece.file);
      auto& source = opened(piece);
      slice_.resize(source.grid().slice_bytes(Axis::z));
      source.read_slices(z - piece.from.z, 1, slice_);
      require_unchanged(piece.file);
      const auto within = piece.first - piece.from;
      const auto width = std::size_t(source.grid().dims.x) * size;
      for (int y = piece.first.y; y < piece.end.y; ++y)
        std::memcpy(out.data() + std::size_t(y) * row + std::size_t(piece.first.x) * size,
                    slice_.data() + std::size_t(y - piece.from.y) * width + std::size_t(within.x) * size,
                    std::size_t(piece.end.x - piece.first.x) * size);
    }
  }

  VolumeSource& opened(const VolumePiece& piece) {
    constexpr std::size_t most_open = 256;  // files
    if (opened_.size() >= most_open && !opened_.contains(&piece)) opened_.clear();
    auto& source = opened_[&piece];
    if (!source) source = piece.open();
    return *source;
  }

  std::vector<VolumePiece> pieces_;
  std::map<const VolumePiece*, std::unique_ptr<VolumeSource>> opened_;
  std::vector<std::byte> slice_;
};

}  // namespace

std::unique_ptr<VolumeSource> pieced_source(const Grid& grid, std::vector<VolumePiece> pieces,
                                            const std::string& where) {
  std::ranges::stable_sort(pieces, {}, [](const VolumePiece& piece) { return piece.first.z; });
  require_full(grid, pieces, where);
  bool concurrent = true;
  for (const auto& piece : pieces) {
    auto source = piece.open();
    if (source->grid().dims == grid.dims) return source;
    concurrent &= source->concurrent();
  }
  return std::make_unique<PiecedSource>(grid, std::move(pieces), concurrent);
}

}  // namespace ringsplat::detail
