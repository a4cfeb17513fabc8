#include <algorithm>
#include <array>
#include <cstring>
#include <glm/vector_relational.hpp>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/encoded_bytes.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "formats/volume_files.hpp"
#include "formats/vti/header.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

struct Chosen {
  const VtiArray& array;
  std::string component;  ///< as --channel has it behind a colon; empty: not chosen
};

const VtiArray* array_named(const VtiPiece& piece, std::string_view name) {
  for (const auto& array : piece.arrays)
    if (array.name == name) return &array;
  return nullptr;
}

/// The active scalars, else the only array.
const VtiArray* default_array(const VtiHeader& header) {
  const auto& arrays = header.pieces.front().arrays;
  for (const bool of_cells : {false, true})
    for (const auto& array : arrays)
      if (array.of_cells == of_cells && !array.name.empty() &&
          array.name == (of_cells ? header.cell_scalars : header.point_scalars))
        return &array;
  return arrays.size() == 1 ? &arrays.front() : nullptr;
}

/// --channel is an array's name, a component of the default array, or both: NAME:COMPONENT.
Chosen choose(const VtiHeader& header, const std::string& channel, const std::filesystem::path& path) {
  const auto& piece = header.pieces.front();
  const auto* array = channel.empty() ? nullptr : array_named(piece, channel);
  if (array != nullptr) return {*array, {}};
  const auto colon = channel.rfind(':');
  if (colon != std::string::npos) {
    array = array_named(piece, channel.substr(0, colon));
    if (array != nullptr) return {*array, channel.substr(colon + 1)};
  }
  array = default_array(header);
  const bool component = array != nullptr && (array->components > 1 || piece.arrays.size() == 1);
  if (array != nullptr && (channel.empty() || component)) return {*array, channel};
  const auto names = joined(piece.arrays, ", ", [](const VtiArray& each) { return excerpt(each.name); });
  if (channel.empty())
    refuse(path, "choose one with --channel: " + names, "it holds {} arrays", piece.arrays.size());
  refuse(path, "its arrays are " + names, "--channel {}: it has no such array", channel);
}

/// For messages.
std::string named(const std::filesystem::path& path, const VtiArray& array) {
  return fmt::format("{}, array '{}'", path.string(), excerpt(array.name));
}

/// The points from `first` to `last` along each axis, or the cells between them. A flat volume has one layer
/// of cells.
glm::ivec3 sizes_of(const VtiArray& array, const glm::ivec3& first, const glm::ivec3& last,
                    const std::filesystem::path& path) {
  glm::ivec3 sizes;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cells = std::int64_t(last[axis]) - first[axis];
    const auto size = array.of_cells ? std::max<std::int64_t>(cells, cells == 0 ? 1 : 0) : cells + 1;
    if (size < 1 || size > std::numeric_limits<int>::max())
      refuse(path, "the extent must hold a point", "its extent is {} to {} along axis {}", first[axis],
             last[axis], axis);
    sizes[axis] = int(size);
  }
  return sizes;
}

/// Points lie on the lattice, cells between; the lattice's point (0, 0, 0) is at the origin, wherever the
/// extent begins.
Grid grid_of(const VtiHeader& header, const VtiArray& array, const std::filesystem::path& path) {
  Grid grid;
  grid.dims = sizes_of(array, header.first, header.last, path);
  glm::dvec3 first(header.first);
  for (int axis = 0; axis < 3; ++axis)
    if (array.of_cells && header.last[axis] > header.first[axis]) first[axis] += 0.5;
  grid.spacing = header.spacing;
  grid.direction = header.direction;
  grid.origin = header.origin + header.direction * (header.spacing * first);
  grid.type = voxel_type(named(path, array), array.type);
  return grid;
}

/// An array behind its numbers: a length, or the sizes of compressed blocks, which are decoded one at a time;
/// those in base64 in order.
class VtiSource final : public LayeredSource {
 public:
  /// Throws InputError when the array's own sizes are not the grid's, or the file cannot hold them.
  VtiSource(const Grid& grid, const std::filesystem::path& path, const VtiArray& array)
      : LayeredSource(grid, {path}, {{"encoding", "base64 or compressed"}}, array.format == Encoding::raw),
        array_(array),
        bytes_(grid.bytes()),
        file_(path) {
    encoded_ = encoded_bytes(file_, array.format, array.begin, array.end);
    if (array.compressor == Compressor::none)
      read_length();
    else
      read_blocks();
  }

  std::uint64_t begin() const { return begin_; }  ///< of the voxels, behind the numbers
 private:
  void read_layer(int z, int, std::span<std::byte> out) override {
    read(std::uint64_t(z) * grid().slice_bytes(Axis::z), out);
    require_unchanged(file_.path());
    to_native_order(out, size_of(grid().type), array_.big_endian);
  }

  void read(std::uint64_t offset, std::span<std::byte> out) {
    if (array_.compressor == Compressor::none) return encoded_->read(begin_ + offset, out);
    while (!out.empty()) {
      const auto block = std::size_t(offset / block_bytes_);
      hold(block);
      const auto within = std::size_t(offset % block_bytes_);
      const auto count = std::min(out.size(), held_.size() - within);
      std::memcpy(out.data(), held_.data() + within, count);
      out = out.subspan(count);
      offset += count;
    }
  }

  [[noreturn]] void fail_array(const std::string& what) const {
    refuse(file_.path(), "the file is damaged or its extents are wrong: write it again", "the array '{}' {}",
           excerpt(array_.name), what);
  }

  std::uint64_t number(std::size_t i) {
    const auto size = std::size_t(array_.header_bytes);
    std::array<std::byte, 8> bytes{};
    encoded_->read(std::uint64_t(i) * size, std::span(bytes).first(size));
    const BinaryFields fields(bytes, array_.big_endian);
    return size == 4 ? fields.at<std::uint32_t>(0) : fields.at<std::uint64_t>(0);
  }

  void read_length() {
    begin_ = std::uint64_t(array_.header_bytes);
    const auto length = number(0);
    // A number of 32 bits is the rest of a longer length.
    const auto expected = array_.header_bytes == 4 ? bytes_ & 0xFFFFFFFFU : bytes_;
    if (length != expected) fail_array(fmt::format("has {} bytes, its extent needs {}", length, bytes_));
    if (encoded_->most() < begin_ || encoded_->most() - begin_ < bytes_)
      require_bytes(file_.path(), encoded_->most(), begin_, bytes_);
  }

  /// Number of blocks, bytes of a whole one, bytes of the last if it is not whole, compressed bytes of each.
  void read_blocks() {
    const auto blocks = number(0), last = number(2);
    block_bytes_ = number(1);
    const auto size = std::uint64_t(array_.header_bytes);
    if (blocks == 0 || block_bytes_ == 0 || last > block_bytes_ || blocks > encoded_->most() / size)
      fail_array(fmt::format("has {} blocks of {} bytes", blocks, block_bytes_));
    const auto whole = last == 0 ? blocks : blocks - 1;
    if (whole > std::numeric_limits<std::int64_t>::max() / block_bytes_ ||
        whole * block_bytes_ + last != bytes_)
      fail_array(fmt::format("has {} blocks of {} bytes, its extent needs {}", blocks, block_bytes_, bytes_));
    begin_ = (3 + blocks) * size;
    ends_.reserve(std::size_t(blocks));
    std::uint64_t end = 0;
    for (std::uint64_t i = 0; i < blocks; ++i) {
      const auto packed = number(std::size_t(3 + i));
      if (packed > encoded_->most() - std::min(encoded_->most(), begin_ + end))
        fail_array(fmt::format("has a block of {} compressed bytes, the file has fewer", packed));
      end += packed;
      ends_.push_back(end);
    }
    const auto ratio = array_.compressor == Compressor::lzma ? any_best_ratio : deflate_best_ratio;
    require_compressed_bytes(file_.path(), end, bytes_, ratio);  // LZ4's is 255
    set_layer(std::max<std::uint64_t>(1, block_bytes_ / grid().slice_bytes(Axis::z)));
  }

  void hold(std::size_t block) {
    if (block == held_block_) return;
    held_block_ = std::numeric_limits<std::size_t>::max();
    const auto begin = block == 0 ? 0 : ends_[block - 1];
    packed_.resize(std::size_t(ends_[block] - begin));
    encoded_->read(begin_ + begin, packed_);
    held_.resize(std::size_t(std::min(block_bytes_, bytes_ - std::uint64_t(block) * block_bytes_)));
    if (!decompress(array_.compressor, packed_, held_))
      fail_array(fmt::format("has a damaged block, {} of {}", block + 1, ends_.size()));
    held_block_ = block;
  }

  VtiArray array_;
  std::uint64_t bytes_;
  InputFile file_;
  std::unique_ptr<EncodedBytes> encoded_;
  std::uint64_t begin_ = 0, block_bytes_ = 0;
  std::vector<std::uint64_t> ends_;  ///< of the compressed blocks, from begin_ on
  std::vector<std::byte> packed_, held_;
  std::size_t held_block_ = std::numeric_limits<std::size_t>::max();
};

/// A binary array's voxels: uncompressed appended ones and text are read as other files' are. `grid`:
/// interleaved components.
std::unique_ptr<VolumeSource> source_of(const Grid& grid, const std::filesystem::path& path,
                                        const VtiArray& array) {
  StoredVoxels stored{.file = path,
                      .offset = array.begin,
                      .encoding = array.format,
                      .end = array.end,
                      .big_endian = array.big_endian,
                      .type = grid.type};
  if (array.format == Encoding::text) return stored_source(grid, {stored});
  auto source = std::make_unique<VtiSource>(grid, path, array);
  if (array.format == Encoding::base64 || array.compressor != Compressor::none) return source;
  stored.offset += source->begin();
  return stored_source(grid, {stored});
}

/// What another piece has of the array.
const VtiArray& same_array(const VtiPiece& piece, const VtiArray& array) {
  for (const auto& other : piece.arrays)
    if (other.name == array.name && other.of_cells == array.of_cells && other.type == array.type &&
        other.components == array.components)
      return other;
  refuse(piece.file, "write all pieces again, with the same arrays",
         "a piece has no array '{}' of {} {} with {} numbers each, as others have", excerpt(array.name),
         excerpt(array.type), array.of_cells ? "cells" : "points", array.components);
}

/// Of points that several pieces have the last piece along each axis counts. Nothing where none is left.
std::optional<VolumePiece> piece_of(const VtiHeader& header, const VtiPiece& piece, const VtiArray& array,
                                    Grid grid) {
  if (!glm::all(glm::lessThanEqual(piece.first, piece.last))) return {};
  const VtiArray& own = same_array(piece, array);
  VolumePiece part{.file = piece.file};
  auto& [begins, ends] = part.box;
  grid.dims = sizes_of(array, piece.first, piece.last, piece.file);
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t first = piece.first[axis], last = piece.last[axis], begin = header.first[axis],
                       end = header.last[axis];
    if (first < begin || last > end)
      refuse(piece.file, piece_hint, "a piece's extent is {} to {} along axis {}, the whole's {} to {}",
             first, last, axis, begin, end);
    // Those at the end, and of a flat volume, have one more.
    const std::int64_t more = last == end && (!array.of_cells || begin == end) ? 1 : 0;
    const std::int64_t ghosts = std::clamp<std::int64_t>(header.ghosts, 0, last - first);
    part.from[axis] = int(first - begin);
    begins[axis] = int(first - begin + (first > begin ? ghosts : 0));
    ends[axis] = int(last - begin + (last < end ? -ghosts : more));
    if (begins[axis] >= ends[axis]) return {};
  }
  const int components = array.components;
  part.from.x *= components, begins.x *= components, ends.x *= components;
  part.open = [grid = interleaved_grid(grid, components, piece.file.string()), file = piece.file, own] {
    return source_of(grid, file, own);
  };
  return part;
}

}  // namespace

std::unique_ptr<VolumeSource> open_vti(const std::filesystem::path& path, const VolumeChoice& choice) {
  auto header = read_vti_header(path);
  auto& arrays = header.pieces.front().arrays;
  // What ParaView hides; not what somebody measured.
  std::erase_if(arrays, [](const VtiArray& array) { return array.name.starts_with("vtkGhost"); });
  if (arrays.empty()) refuse(path, "save the volume's scalars, too", "it holds no array of points or cells");
  const auto [array, component] = choose(header, choice.channel, path);
  const Grid grid = grid_of(header, array, path);
  const int components = array.components;
  const auto wide = interleaved_grid(grid, components, path.string());
  std::vector<VolumePiece> pieces;
  for (const auto& piece : header.pieces)
    if (auto box = piece_of(header, piece, array, grid)) pieces.push_back(std::move(*box));
  auto source = channel_source(pieced_source(wide, std::move(pieces), path.string()), grid, components,
                               component, named(path, array));
  const auto channels = std::max<std::int64_t>(components, std::int64_t(arrays.size()));
  return with_notes(std::move(source), {.quantity = array.name, .channels = int(channels)});
}

}  // namespace ringsplat::detail
