#include "formats/vti/source.hpp"

#include <fmt/format.h>
#include <lz4.h>
#include <lzma.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/encoded_bytes.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "formats/volume_files.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

/// False unless `in` decodes to exactly `out`.
bool decompress(VtiCompressor compressor, std::span<const std::byte> in, std::span<std::byte> out) {
  const auto* from = reinterpret_cast<const unsigned char*>(in.data());
  auto* to = reinterpret_cast<unsigned char*>(out.data());
  if (compressor == VtiCompressor::zlib) {
    uLongf made = out.size();
    return uncompress(to, &made, from, in.size()) == Z_OK && made == out.size();
  }
  if (compressor == VtiCompressor::lz4) {
    constexpr std::size_t most = LZ4_MAX_INPUT_SIZE;
    if (in.size() > most || out.size() > most) return false;
    const int made = LZ4_decompress_safe(reinterpret_cast<const char*>(from), reinterpret_cast<char*>(to),
                                         int(in.size()), int(out.size()));
    return made >= 0 && std::size_t(made) == out.size();
  }
  // The largest dictionary that liblzma's presets have takes 65 MiB.
  std::uint64_t memory = 80 << 20;
  std::size_t read = 0, made = 0;
  return lzma_stream_buffer_decode(&memory, 0, nullptr, from, &read, in.size(), to, &made, out.size()) ==
             LZMA_OK &&
         made == out.size();
}

std::uint64_t best_ratio(VtiCompressor compressor) {
  return compressor == VtiCompressor::lzma ? any_best_ratio : deflate_best_ratio;  // LZ4's is 255
}

/// The array behind its numbers: a length, or the sizes of compressed blocks.
class Content {
 public:
  Content(const Grid& grid, const std::filesystem::path& path, const VtiHeader& header, const VtiArray& array)
      : header_(header), array_(array), bytes_(grid.bytes()), file_(path) {
    const auto make = array.format == VtiFormat::raw ? plain_bytes : base64_bytes;
    encoded_ = make(file_, array.begin, array.end);
    if (header.compressor == VtiCompressor::none)
      read_length();
    else
      read_blocks();
  }

  const InputFile& file() const { return file_; }
  /// Of the voxels behind the numbers.
  std::uint64_t begin() const { return begin_; }

  void read(std::uint64_t offset, std::span<std::byte> out) {
    if (header_.compressor == VtiCompressor::none) return encoded_->read(begin_ + offset, out);
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

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}: the array '{}' {}", file_.path().string(), excerpt(array_.name), what),
                     "the file is damaged or its extents are wrong: write it again");
  }

  std::uint64_t number(std::size_t i) {
    const auto size = std::size_t(header_.header_bytes);
    std::array<std::byte, 8> bytes{};
    const auto part = std::span(bytes).subspan(header_.big_endian ? 8 - size : 0, size);
    encoded_->read(std::uint64_t(i) * size, part);
    std::uint64_t value = 0;
    to_native_order(bytes, 8, header_.big_endian);
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }

  void read_length() {
    begin_ = std::uint64_t(header_.header_bytes);
    const auto length = number(0);
    // A number of 32 bits is the rest of a longer length.
    const auto expected = header_.header_bytes == 4 ? bytes_ & 0xFFFFFFFFU : bytes_;
    if (length != expected) fail(fmt::format("has {} bytes, its extent needs {}", length, bytes_));
    if (encoded_->most() < begin_ || encoded_->most() - begin_ < bytes_)
      require_bytes(file_.path(), encoded_->most(), begin_, bytes_);
  }

  /// Number of blocks, bytes of a whole one, bytes of the last if it is not whole, compressed bytes of each.
  void read_blocks() {
    const auto blocks = number(0), last = number(2);
    block_bytes_ = number(1);
    const auto size = std::uint64_t(header_.header_bytes);
    if (blocks == 0 || block_bytes_ == 0 || last > block_bytes_ || blocks > encoded_->most() / size)
      fail(fmt::format("has {} blocks of {} bytes", blocks, block_bytes_));
    const auto whole = last == 0 ? blocks : blocks - 1;
    if (whole > std::numeric_limits<std::int64_t>::max() / block_bytes_ ||
        whole * block_bytes_ + last != bytes_)
      fail(fmt::format("has {} blocks of {} bytes, its extent needs {}", blocks, block_bytes_, bytes_));
    begin_ = (3 + blocks) * size;
    ends_.reserve(std::size_t(blocks));
    std::uint64_t end = 0;
    for (std::uint64_t i = 0; i < blocks; ++i) {
      const auto packed = number(std::size_t(3 + i));
      if (packed > encoded_->most() - std::min(encoded_->most(), begin_ + end))
        fail(fmt::format("has a block of {} compressed bytes, the file has fewer", packed));
      end += packed;
      ends_.push_back(end);
    }
    require_compressed_bytes(file_.path(), end, bytes_, best_ratio(header_.compressor));
  }

  void hold(std::size_t block) {
    if (block == held_block_) return;
    held_block_ = std::numeric_limits<std::size_t>::max();
    const auto begin = block == 0 ? 0 : ends_[block - 1];
    packed_.resize(std::size_t(ends_[block] - begin));
    encoded_->read(begin_ + begin, packed_);
    held_.resize(std::size_t(std::min(block_bytes_, bytes_ - std::uint64_t(block) * block_bytes_)));
    if (!decompress(header_.compressor, packed_, held_))
      fail(fmt::format("has a damaged block, {} of {}", block + 1, ends_.size()));
    held_block_ = block;
  }

  VtiHeader header_;
  VtiArray array_;
  std::uint64_t bytes_;
  InputFile file_;
  std::unique_ptr<EncodedBytes> encoded_;
  std::uint64_t begin_ = 0, block_bytes_ = 0;
  std::vector<std::uint64_t> ends_;  ///< of the compressed blocks, from begin_ on
  std::vector<std::byte> packed_, held_;
  std::size_t held_block_ = std::numeric_limits<std::size_t>::max();
};

class VtiSource final : public VolumeSource {
 public:
  VtiSource(const Grid& grid, std::unique_ptr<Content> content, bool big_endian)
      : grid_(grid), content_(std::move(content)), big_endian_(big_endian) {}

  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return false; }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto bytes = grid_.slice_bytes(Axis::z);
    const auto wanted = out.first(std::size_t(count) * bytes);
    content_->read(std::uint64_t(first) * bytes, wanted);
    content_->file().require_unchanged();
    to_native_order(wanted, size_of(grid_.type), big_endian_);
  }
  Facts facts() const override {
    Facts facts{{"encoding", "base64 or compressed"}};
    add_facts_of(content_->file(), 0, content_->file().size(), facts);
    return facts;
  }

 private:
  Grid grid_;
  std::unique_ptr<Content> content_;
  bool big_endian_;
};

}  // namespace

std::unique_ptr<VolumeSource> vti_source(const Grid& grid, const std::filesystem::path& path,
                                         const VtiHeader& header, const VtiArray& array) {
  auto content = std::make_unique<Content>(grid, path, header, array);
  if (array.format == VtiFormat::raw && header.compressor == VtiCompressor::none)
    return stored_source(grid, {.file = path,
                                .offset = array.begin + content->begin(),
                                .big_endian = header.big_endian,
                                .type = grid.type});
  return std::make_unique<VtiSource>(grid, std::move(content), header.big_endian);
}

}  // namespace ringsplat::detail
