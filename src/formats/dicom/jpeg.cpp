#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/dicom/frames.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

// Markers of ITU-T T.81 (table B.1), T.87 (annex C) and T.800 (table A.2); all are behind a byte FF.
enum Marker : unsigned {
  first_frame = 0xC0,  // C0 to CF, but C4, C8 and CC, begin a frame
  huffman_tables = 0xC4,
  reserved_frame = 0xC8,
  arithmetic_tables = 0xCC,
  last_frame = 0xCF,
  first_restart = 0xD0,
  last_restart = 0xD7,
  image_begin = 0xD8,
  image_end = 0xD9,
  scan = 0xDA,
  quantisation_tables = 0xDB,
  restart_interval = 0xDD,
  first_application = 0xE0,
  last_application = 0xEF,
  comment = 0xFE,
  ls_frame = 0xF7,
  ls_parameters = 0xF8,
  codestream_begin = 0x4F,
  first_main = 0x50,
  codestream_size = 0x51,
  coding_style = 0x52,
  last_main = 0x6F,
  tile_part = 0x90,
  tile_data = 0x93
};

/// One frame's walk from segment to segment.
class FrameWalk {
 public:
  FrameWalk(const DicomFile& file, const DicomShape& shape, std::span<const std::byte> bytes)
      : file_(file), shape_(shape), bytes_(bytes) {}

  std::vector<std::byte> jpeg() {
    if (marker() != image_begin) fail("does not begin as one");
    std::vector<std::byte> sound{std::byte{0xFF}, std::byte{image_begin}};
    bool has_frame = false, has_scan = false;
    for (;;) {
      const auto found = marker();
      if (found == image_end && has_scan) break;
      const auto begin = at_;
      const auto length = number(at_, 2);
      if (length < 2 || length > bytes_.size() - at_) fail("is cut short or damaged");
      if (is_frame(found)) {
        if (has_frame) fail("has two frame headers");
        has_frame = true;
        check_frame(found);
      }
      // Only one scan: a pixel has one sample, and no transfer syntax here needs several scans.
      if (found == scan && (has_scan || !has_frame)) fail("has its parts in a wrong order");
      at_ += length;
      if (found == scan) {
        has_scan = true;
        skip_scan();
      }
      if (found == comment || (found >= first_application && found <= last_application)) continue;
      if (!is_frame(found) && !is_table(found) && found != scan) fail("is damaged: an unknown marker");
      sound.insert(sound.end(), {std::byte{0xFF}, std::byte(found)});
      const auto part = bytes_.subspan(begin, at_ - begin);
      sound.insert(sound.end(), part.begin(), part.end());
    }
    sound.insert(sound.end(), {std::byte{0xFF}, std::byte{image_end}});
    return sound;
  }

  std::vector<std::byte> jpeg_2000() {
    if (marker() != codestream_begin || marker() != codestream_size) fail("does not begin as one");
    constexpr std::size_t size_bytes = 41;  // for one component
    if (number(at_, 2) != size_bytes || bytes_.size() - at_ < size_bytes) fail("is not of one component");
    const auto word = [this](std::size_t i) { return std::uint64_t(number(at_ + 4 + 4 * i, 4)); };
    if (word(0) < word(2) || word(1) < word(3) || word(4) == 0 || word(5) == 0) fail("has no area");
    const auto precision = (number(at_ + 38, 1) & 0x7F) + 1;
    if (number(at_ + 39, 1) != 1 || number(at_ + 40, 1) != 1) fail("is of fewer samples than pixels");
    require_size(word(0) - word(2), word(1) - word(3), precision);
    at_ += size_bytes;
    walk_segments(tile_part);
    walk_tile_parts();
    return {bytes_.begin(), bytes_.begin() + std::ptrdiff_t(at_)};
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}: a compressed frame {}", file_.path.string(), what),
                     "copy or write the file again");
  }

  std::uint32_t number(std::size_t at, std::size_t count) const {
    if (at > bytes_.size() || bytes_.size() - at < count) fail("is cut short");
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < count; ++i)
      value = value << 8 | std::to_integer<std::uint32_t>(bytes_[at + i]);
    return value;
  }

  /// Walks segments up to a marker. GDCM does so too, but beyond the end.
  void walk_segments(unsigned last) {
    for (auto found = marker(); found != last; found = marker()) {
      const auto length = number(at_, 2);
      if (found < first_main || found > last_main || length < 2 || length > bytes_.size() - at_)
        fail("is cut short or damaged");
      constexpr std::uint32_t least_style = 12;  // bytes
      if (found == coding_style && length < least_style) fail("does not say how it is coded");
      has_style_ |= found == coding_style;
      at_ += length;
    }
  }

  /// Walks the tile parts, from behind the first one's marker to the end of the image.
  void walk_tile_parts() {
    if (!has_style_) fail("does not say how it is coded");
    for (unsigned found = tile_part; found != image_end; found = marker()) {
      const auto begin = at_ - 2;
      const auto length = number(at_ + 4, 4);
      constexpr std::uint32_t header_bytes = 12;  // with its marker
      if (found != tile_part || number(at_, 2) != header_bytes - 2 || length > bytes_.size() - begin)
        fail("is cut short or damaged");
      at_ = begin + header_bytes;
      walk_segments(tile_data);
      if (length != 0 && begin + length < at_) fail("is cut short or damaged");
      at_ = begin + length;
      if (length == 0) {  // the last tile part: up to the end
        at_ = bytes_.size();
        return;
      }
    }
  }

  /// Any number of bytes FF may precede a marker.
  unsigned marker() {
    if (number(at_, 1) != 0xFF) fail("is cut short or damaged");
    while (number(at_, 1) == 0xFF) ++at_;
    return number(at_++, 1);
  }

  static bool is_frame(unsigned found) {
    return found == ls_frame || (found >= first_frame && found <= last_frame && found != huffman_tables &&
                                 found != reserved_frame && found != arithmetic_tables);
  }

  static bool is_table(unsigned found) {
    return found == huffman_tables || found == quantisation_tables || found == restart_interval ||
           found == ls_parameters;
  }

  void check_frame(unsigned found) const {
    const unsigned kind = found - first_frame;
    const bool right = shape_.codec == DicomCodec::jpeg_ls         ? found == ls_frame
                       : shape_.codec == DicomCodec::lossless_jpeg ? kind == 3
                                                                   : kind <= 1;
    if (!right) fail("is coded in another way than the transfer syntax says");
    if (number(at_ + 7, 1) != 1) fail("is not of one component");
    require_size(number(at_ + 5, 2), number(at_ + 3, 2), number(at_ + 2, 1));
  }

  void require_size(std::uint64_t width, std::uint64_t height, std::uint32_t bits) const {
    if (width != std::uint64_t(shape_.columns) || height != std::uint64_t(shape_.rows))
      fail(fmt::format("has {} x {} pixels, the DICOM header says {} x {}", width, height, shape_.columns,
                       shape_.rows));
    // GDCM has one decoder for each of these and chooses it by the DICOM header.
    const auto decoder = [](int depth) { return depth <= 8 ? 8 : depth <= 12 ? 12 : 16; };
    const bool by_decoder = shape_.codec == DicomCodec::jpeg || shape_.codec == DicomCodec::lossless_jpeg;
    const auto depth = int(std::min(bits, 99U));
    if (shape_.codec == DicomCodec::jpeg && depth != 8 && depth != 12)
      fail(fmt::format("has {} bits per pixel, 8 or 12 are possible", bits));
    if (depth < 2 || depth > shape_.bits_allocated ||
        (shape_.bits_allocated == 8 ? depth != 8 : depth <= 8) ||
        (by_decoder && decoder(depth) != decoder(shape_.bits_stored)))
      fail(fmt::format("has {} bits per pixel, the DICOM header says {} stored in {}", bits,
                       shape_.bits_stored, shape_.bits_allocated));
  }

  /// Moves to the next marker that is not part of the scan.
  void skip_scan() {
    for (;; ++at_) {
      const auto rest = bytes_.subspan(std::min(at_, bytes_.size()));
      at_ += std::size_t(std::find(rest.begin(), rest.end(), std::byte{0xFF}) - rest.begin());
      const auto next = number(at_ + 1, 1);
      const bool data = shape_.codec == DicomCodec::jpeg_ls ? next < 0x80 : next == 0;
      if (!data && next != 0xFF && (next < first_restart || next > last_restart)) return;
    }
  }

  const DicomFile& file_;
  const DicomShape& shape_;
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool has_style_ = false;
};

}  // namespace

std::vector<std::byte> sound_jpeg_frame(const DicomFile& file, const DicomShape& shape,
                                        const std::vector<std::byte>& frame) {
  FrameWalk walk(file, shape, frame);
  return shape.codec == DicomCodec::jpeg_2000 ? walk.jpeg_2000() : walk.jpeg();
}

}  // namespace ringsplat::detail
