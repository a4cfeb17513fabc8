#include "formats/volume_files.hpp"

#include <fmt/printf.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <map>

#include "base/fingerprint.hpp"
#include "base/text.hpp"
#include "formats/limits.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::uint64_t most_hashed = 64 << 10;  ///< bytes at either end of a file
/// Bytes hashed of all of a volume's files together, but at least `least_hashed` of each: many small files on
/// a shared disk are slow to read.
constexpr std::uint64_t most_hashed_in_all = 16 << 20;
constexpr std::uint64_t least_hashed = 4 << 10;

std::string hash_of(const InputFile& file, std::uint64_t offset, std::uint64_t bytes) {
  std::vector<std::byte> part(bytes);
  file.read(offset, part);
  return fmt::format("{:016x}", fingerprint(part));
}

/// `of`: what the fields' names end with.
void add_facts(const InputFile& file, std::uint64_t offset, std::uint64_t bytes, std::uint64_t most,
               const std::string& of, Facts& facts) {
  const auto hashed = std::min(bytes, most);
  facts.push_back({"file size" + of, fmt::format("{} bytes", file.size())});
  facts.push_back({"hash of the first bytes" + of, hash_of(file, offset, hashed)});
  facts.push_back({"hash of the last bytes" + of, hash_of(file, offset + bytes - hashed, hashed)});
}

FileStamp stamp_at(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0)
    throw InputError(fmt::format("cannot open {}: {}", file.string(), std::strerror(errno)),
                     "check the path and the permissions");
  return stamp_of(status);
}

/// `pieces`: sorted along z.
void require_full(const Grid& grid, const std::vector<VolumePiece>& pieces, const std::string& where) {
  if (pieces.size() > most_pieces) refuse(where, "write fewer of them", "it has {} pieces", pieces.size());
  std::int64_t held = 0;
  for (auto piece = pieces.begin(); piece != pieces.end(); ++piece) {
    const auto size = piece->box.dims();
    held += std::int64_t{size.x} * size.y * size.z;
    for (auto other = piece + 1; other != pieces.end() && other->box.first.z < piece->box.end.z; ++other)
      if (meet(piece->box, other->box))
        refuse(where, piece_hint, "the pieces {} and {} overlap", piece->file.string(), other->file.string());
  }
  if (held != grid.voxels())
    refuse(where, piece_hint, "its pieces leave a gap: they hold {} of {} voxels", held, grid.voxels());
}

class PiecedSource final : public LayeredSource {
 public:
  PiecedSource(const Grid& grid, std::vector<VolumePiece> pieces, bool concurrent)
      : LayeredSource(grid, mapped(pieces, &VolumePiece::file), {{"encoding", "pieces"}}, concurrent),
        pieces_(std::move(pieces)) {}

 private:
  void read_layer(int z, int, std::span<std::byte> out) override {
    const auto size = size_of(grid().type), row = std::size_t(grid().dims.x) * size;
    for (const auto& piece : pieces_) {
      const auto& [first, end] = piece.box;
      if (z < first.z || z >= end.z) continue;
      require_unchanged(piece.file);
      auto& source = opened(piece);
      slice_.resize(source.grid().slice_bytes(Axis::z));
      source.read_slices(z - piece.from.z, 1, slice_);
      require_unchanged(piece.file);
      const auto within = first - piece.from;
      const auto width = std::size_t(source.grid().dims.x) * size;
      for (int y = first.y; y < end.y; ++y)
        std::memcpy(out.data() + std::size_t(y) * row + std::size_t(first.x) * size,
                    slice_.data() + std::size_t(y - piece.from.y) * width + std::size_t(within.x) * size,
                    std::size_t(end.x - first.x) * size);
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

std::vector<std::string> numbered_names(const std::string& pattern, std::int64_t first, std::int64_t count,
                                        std::int64_t step) {
  const auto percent = pattern.find('%'), letter = pattern.find_first_not_of("0123456789", percent + 1);
  constexpr std::size_t most_digits = 3;
  std::vector<std::string> names;
  if (percent == std::string::npos || letter == std::string::npos || pattern[letter] != 'd' ||
      letter - percent > 1 + most_digits || (letter > percent + 1 && pattern[percent + 1] != '0') ||
      pattern.find('%', letter) != std::string::npos)
    return names;
  for (std::int64_t k = 0; k < count; ++k) names.push_back(fmt::sprintf(pattern, first + k * step));
  return names;
}

VolumeFiles::VolumeFiles(const std::vector<std::filesystem::path>& files) {
  for (const auto& file : files) {
    if (!files_.empty() && files_.back() == file) continue;
    files_.push_back(file);
    stamps_.emplace(file.string(), stamp_at(file));
  }
}

void VolumeFiles::require_unchanged(const std::filesystem::path& file) const {
  require_same_stamp(file, stamps_.at(file.string()), stamp_at(file));
}

Facts VolumeFiles::facts() const {
  if (files_.size() == 1) return facts(0, stamps_.at(files_[0].string()).bytes);
  Facts facts{{"number of files", fmt::format("{}", files_.size())}};
  const auto most = std::clamp(most_hashed_in_all / (2 * files_.size()), least_hashed, most_hashed);
  for (std::size_t k = 0; k < files_.size(); ++k)
    facts.push_back({fmt::format("file {}", k + 1), files_[k].filename().string()});
  for (const auto& path : files_) {
    const InputFile file(path);
    add_facts(file, 0, file.size(), most, " of " + path.filename().string(), facts);
  }
  return facts;
}

Facts VolumeFiles::facts(std::uint64_t offset, std::uint64_t bytes) const {
  Facts facts;
  add_facts(InputFile(files_[0]), offset, bytes, most_hashed, "", facts);
  return facts;
}

void LayeredSource::read_slices(int first, int count, std::span<std::byte> out) {
  const std::size_t bytes = grid_.slice_bytes(Axis::z);
  for (int z = first; z < first + count;) {
    const int begin = z / depth_ * depth_, end = std::min(begin + depth_, grid_.dims.z),
              stop = std::min(end, first + count);
    const auto part = out.subspan(std::size_t(z - first) * bytes, std::size_t(stop - z) * bytes);
    if (z == begin && stop == end) {
      read_layer(begin, end, part);
    } else {
      if (kept_first_ != begin) {
        kept_first_ = -1;
        kept_.resize(std::size_t(end - begin) * bytes);
        read_layer(begin, end, kept_);
        kept_first_ = begin;
      }
      std::memcpy(part.data(), kept_.data() + std::size_t(z - begin) * bytes, part.size());
    }
    z = stop;
  }
}

std::unique_ptr<VolumeSource> pieced_source(const Grid& grid, std::vector<VolumePiece> pieces,
                                            const std::string& where) {
  std::ranges::stable_sort(pieces, {}, [](const VolumePiece& piece) { return piece.box.first.z; });
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
