#include <algorithm>
#include <array>
#include <utility>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "formats/stored_source.hpp"
#include "formats/volume_files.hpp"
#include "formats/zarr/metadata.hpp"

namespace ringsplat::detail::zarr {
namespace {

std::filesystem::path file_of(const Node& node, const Array& array, const Sizes& place) {
  std::string name = array.prefix;
  for (std::size_t i = 0; i < place.size(); ++i) {
    const auto k = array.n5 ? place.size() - 1 - i : i;
    name += fmt::format("{}{}", i == 0 ? "" : array.separator, place[k] / array.file[k]);
  }
  return node.folder / name;
}

/// The metadata and the first chunk stand for all files.
std::vector<std::filesystem::path> files_of(const Node& node, const Array& array, const ArrayPart& part) {
  std::vector<std::filesystem::path> files{node.file, file_of(node, array, part.first)};
  if (!std::filesystem::exists(files.back())) files.pop_back();
  return files;
}

/// Calls f for the places from `first` on that lie before `end` along each axis, in steps.
template <class F>
void for_each_place(const Sizes& first, const Sizes& end, const Sizes& step, F&& f) {
  Sizes at = first;
  for (auto k = at.size(); k > 0;) {
    f(at);
    for (k = at.size(); k > 0 && (at[k - 1] += step[k - 1]) >= end[k - 1]; --k) at[k - 1] = first[k - 1];
  }
}

/// Part of an array as a volume. Holds one chunk, decoded and as its file has it, beside the layer of chunks
/// that is asked for.
class ZarrSource final : public LayeredSource {
 public:
  ZarrSource(const Grid& grid, const Node& node, Array array, const ArrayPart& part, Facts facts)
      : LayeredSource(grid, files_of(node, array, part), std::move(facts)),
        node_(node),
        array_(std::move(array)),
        part_(part),
        from_(array_.shape.size()),
        to_(array_.shape.size(), 1),
        first_slice_(part.lattice[2] >= 0 ? int(part.first[std::size_t(part.lattice[2])]) : 0) {
    std::int64_t step = 1;
    for (auto k = from_.size(); k > 0; --k) {
      const auto axis = std::size_t(array_.order[k - 1]);
      from_[axis] = step;
      step *= array_.chunk[axis];
    }
    // Interleaved numbers lie beside each other; of other axes than these only one value is taken.
    const std::int64_t steps[] = {part.components, grid.dims.x, std::int64_t{grid.dims.x} * grid.dims.y};
    for (std::size_t k = 0; k < 3; ++k)
      if (part.lattice[k] >= 0) to_[std::size_t(part.lattice[k])] = steps[k];
    if (part.lattice[2] >= 0) set_layer(std::uint64_t(array_.chunk[std::size_t(part.lattice[2])]));
  }

 private:
  void read_layer(int begin, int stop, std::span<std::byte> out) override {
    const auto z = part_.lattice[2];
    if (z >= 0)
      part_.first[std::size_t(z)] = first_slice_ + begin, part_.end[std::size_t(z)] = first_slice_ + stop;
    Sizes first = part_.first;
    for (std::size_t k = 0; k < first.size(); ++k) first[k] -= first[k] % array_.chunk[k];
    visit_type(grid().type, [&](auto zero) {
      auto* const voxels = reinterpret_cast<decltype(zero)*>(out.data());
      for_each_place(first, part_.end, array_.chunk, [&](const Sizes& chunk) { copy(chunk, voxels); });
    });
  }

  /// What a chunk has of the part, row by row along the last axis. `chunk`: its first place. `to`: the part's
  /// first voxel.
  template <class T>
  void copy(const Sizes& chunk, T* to) {
    const bool there = decode(chunk);
    const T fill = T(array_.fill);
    Sizes first = part_.first, end = part_.end;
    for (std::size_t k = 0; k < chunk.size(); ++k) {
      first[k] = std::max(first[k], chunk[k]);
      end[k] = std::min(end[k], chunk[k] + array_.chunk[k]);
    }
    const auto count = end.back() - first.back(), step = there ? from_.back() : 0;
    Sizes rows(chunk.size(), 1);
    rows.back() = count;
    for_each_place(first, end, rows, [&](const Sizes& at) {
      const T* value = there ? reinterpret_cast<const T*>(values_.data()) : &fill;
      T* voxel = to;
      for (std::size_t k = 0; k < at.size(); ++k) {
        value += there ? (at[k] - chunk[k]) * from_[k] : 0;
        voxel += (at[k] - part_.first[k]) * to_[k];
      }
      if (step == 1 && to_.back() == 1) return void(std::copy_n(value, count, voxel));
      for (auto i = count; i > 0; --i, value += step, voxel += to_.back()) *voxel = *value;
    });
  }

  /// Makes `values_` those of a chunk; false when it is not there.
  bool decode(const Sizes& chunk) {
    if (held_ == chunk) return true;
    held_.clear();
    const auto path = file_of(node_, array_, chunk);
    std::error_code unknown;  // it may be there, and opening it says why it cannot be read
    if (!std::filesystem::exists(path, unknown) && !unknown) return false;
    if (!file_ || file_->path() != path) file_.emplace(path);
    std::uint64_t offset = 0, bytes = file_->size();
    if (array_.sharded && !find_in_shard(chunk, offset, bytes)) return false;
    if (array_.n5) read_sizes(chunk, offset, bytes);
    if (offset > file_->size() || bytes > file_->size() - offset || bytes < array_.checksum)
      fail("do not lie within it");
    unpack(offset, bytes - array_.checksum);
    held_ = chunk;
    return true;
  }

  /// By the shard's index; false when it says that the chunk is not there.
  bool find_in_shard(const Sizes& chunk, std::uint64_t& offset, std::uint64_t& bytes) {
    std::int64_t number = 0;
    for (std::size_t k = 0; k < chunk.size(); ++k)
      number = (number * array_.file[k] + chunk[k] % array_.file[k]) / array_.chunk[k];
    std::array<std::uint64_t, 2> place{};
    const auto index = array_.chunks * sizeof(place) + array_.index_checksum;
    if (bytes < index) fail("are not all in its index, which is cut short");
    const auto out = std::as_writable_bytes(std::span(place));
    file_->read((array_.index_first ? 0 : bytes - index) + std::uint64_t(number) * sizeof(place), out);
    to_native_order(out, sizeof(place[0]), false);
    offset = place[0];
    bytes = place[1];
    return (offset & bytes) != ~std::uint64_t{0};
  }

  /// Of N5: a number that is 0, the number of axes, the sizes, which may end where the array does.
  void read_sizes(const Sizes& chunk, std::uint64_t& offset, std::uint64_t& bytes) {
    std::vector<std::byte> head(4 + 4 * chunk.size());
    file_->read(0, head);
    const BinaryFields fields(head, true);
    if (fields.at<std::uint32_t>(0) != chunk.size()) fail("have other axes than the array");
    array_.chunk_bytes = array_.type->bytes();
    for (std::size_t k = chunk.size(), at = 4; k-- > 0; at += 4) {
      const std::int64_t size = fields.at<std::uint32_t>(at), most = array_.chunk[k];
      if (size > most || size < std::min(most, array_.shape[k] - chunk[k]))
        fail("are not of the size that the metadata say");
      from_[k] = std::int64_t(array_.chunk_bytes / array_.type->bytes());
      array_.chunk_bytes *= std::uint64_t(size);
    }
    offset = head.size();
    bytes -= head.size();
  }

  void unpack(std::uint64_t offset, std::uint64_t bytes) {
    require_compressed_bytes(file_->path(), bytes, array_.chunk_bytes, any_best_ratio);
    values_.resize(std::size_t(array_.chunk_bytes));
    if (array_.compressor == Compressor::deflate) {
      const auto inflated = encoded_bytes(*file_, Encoding::deflate, offset);
      inflated->read(0, values_);
      inflated->verify_end();
    } else {
      // numcodecs writes four bytes with the size before its LZ4 blocks.
      const std::uint64_t before = array_.compressor == Compressor::lz4 ? 4 : 0;
      packed_.resize(std::size_t(bytes - std::min(bytes, before)));
      file_->read(offset + before, packed_);
      if (!decompress(array_.compressor, packed_, values_))
        fail("are damaged, or not of the size that the metadata say");
    }
    to_native_order(values_, array_.type->bytes(), array_.big_endian);
    const auto code = array_.type->code;
    if (code == "i8" || code == "u8") doubles_of_integers(values_, code == "i8", file_->path().string());
    if (code != "f2") return;
    packed_.resize(2 * values_.size());
    widen_halves(values_, packed_);
    values_.swap(packed_);
  }

  [[noreturn]] void fail(const char* what) const {
    refuse(file_->path(), "copy or write the file again", "its chunks {}", what);
  }

  Node node_;
  Array array_;
  ArrayPart part_;   ///< of the layer that was read last
  Sizes from_, to_;  ///< steps from one value to the next along each axis, in a chunk and in a layer
  int first_slice_;  ///< of the array, along the lattice's z
  std::optional<InputFile> file_;  ///< that was read last
  Sizes held_;                     ///< the chunk that `values_` are of
  std::vector<std::byte> packed_, values_;
};

}  // namespace

std::unique_ptr<VolumeSource> array_source(const Grid& grid, const Node& node, Array array,
                                           const ArrayPart& part, Facts facts) {
  return std::make_unique<ZarrSource>(grid, node, std::move(array), part, std::move(facts));
}

}  // namespace ringsplat::detail::zarr
