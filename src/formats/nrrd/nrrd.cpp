#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <utility>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/nrrd/header.hpp"
#include "formats/nrrd/layout.hpp"
#include "formats/piece_files.hpp"
#include "formats/stored_source.hpp"
#include "formats/text_reader.hpp"
#include "formats/text_source.hpp"
#include "formats/whole_source.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

/// A volume whose bytes are written as two hexadecimal digits each, with or without blanks between them.
class HexSource final : public WholeFileSource {
 public:
  HexSource(const Grid& grid, const std::filesystem::path& path, std::uint64_t offset, bool big_endian)
      : WholeFileSource(grid, path), offset_(offset), big_endian_(big_endian) {
    require_bytes(path_, InputFile(path_).size(), offset_, 2 * grid.bytes());
  }

 private:
  void decode_file(std::span<std::byte> voxels) override {
    const InputFile file(path_);
    TextReader text(file, offset_);
    for (auto& byte : voxels) {
      const auto high = digit(text);
      byte = std::byte(high << 4 | digit(text));
    }
    to_native_order(voxels, size_of(grid().type), big_endian_);
  }

  unsigned digit(TextReader& text) const {
    auto c = text.peek();
    for (; c && std::isspace(static_cast<unsigned char>(*c)) != 0; c = text.peek()) text.advance();
    unsigned value = 0;
    constexpr int base = 16;
    if (!c || std::from_chars(&*c, &*c + 1, value, base).ec != std::errc())
      throw InputError(fmt::format("{}: byte {} is no hexadecimal digit", path_.string(), text.position()),
                       "the file was cut short or is damaged: copy or write it again");
    text.advance();
    return value;
  }

  std::uint64_t offset_;
  bool big_endian_;
};

/// The byte of a file behind the skipped lines and, unless it is compressed, behind the skipped bytes.
std::uint64_t offset_in(const NrrdHeader& header, const std::filesystem::path& path,
                        std::uint64_t voxel_bytes) {
  const InputFile file(path);
  auto offset = header.end;
  if (header.line_skip > 0) {
    TextReader text(file, offset);
    for (std::int64_t k = 0; k < header.line_skip; ++k)
      if (!text.line()) require_bytes(path, file.size(), file.size(), voxel_bytes);
    offset = text.position();
  }
  if (header.encoding == NrrdEncoding::gzip) return offset;
  if (header.byte_skip >= 0) return offset + std::uint64_t(header.byte_skip);
  const auto behind = std::uint64_t(-1 - header.byte_skip);
  return file.size() - std::min(file.size(), voxel_bytes + behind);
}

/// The voxels of one file, raw or gzip, which has `voxel_bytes` of them in all.
StoredVoxels stored_in(const NrrdHeader& header, const std::filesystem::path& file,
                       std::uint64_t voxel_bytes) {
  const bool gzip = header.encoding == NrrdEncoding::gzip;
  return {.file = file,
          .offset = offset_in(header, file, voxel_bytes),
          .compressed = gzip,
          .skip = gzip ? std::uint64_t(header.byte_skip) : 0,
          .big_endian = header.big_endian,
          .type = header.type};
}

/// The voxels of one file, in any encoding.
std::unique_ptr<VolumeSource> source_in(const NrrdHeader& header, const Grid& grid,
                                        const std::filesystem::path& file) {
  if (header.encoding == NrrdEncoding::text)
    return text_source(grid, file, offset_in(header, file, grid.bytes()));
  if (header.encoding == NrrdEncoding::hex)
    return std::make_unique<HexSource>(grid, file, offset_in(header, file, 2 * grid.bytes()),
                                       header.big_endian);
  return stored_source(grid, stored_in(header, file, grid.bytes()));
}

/// One frame and channel of a file that has several.
std::unique_ptr<VolumeSource> source_of(const NrrdHeader& header, const NrrdLayout& layout,
                                        const VolumeChoice& choice) {
  const auto where = header.path.string();
  if (header.files.size() > 1 || header.encoding == NrrdEncoding::text ||
      header.encoding == NrrdEncoding::hex)
    throw InputError(fmt::format("{}: several volumes or components as {}", where,
                                 header.files.size() > 1 ? "several files" : "text"),
                     "write it anew in one file with encoding gzip or raw");
  const auto wide = interleaved_grid(layout.grid, layout.leading, where);
  auto stored =
      stored_in(header, header.files[0], bytes_of_volumes(header.path, wide.bytes(), layout.volumes));
  const auto before = stored.compressed ? stored.skip : stored.offset;
  const auto total = bytes_of_volumes(header.path, wide.bytes(), layout.volumes, before);
  const auto size = InputFile(stored.file).size();
  if (stored.compressed)
    require_compressed_bytes(stored.file, size, total, deflate_best_ratio);
  else
    require_bytes(stored.file, size, before, total - before);

  const int frame = std::clamp(choice.frame.value_or(0), 0, layout.frames - 1);
  const auto channel = layout.channels > 1
                           ? choose_channel(choice.channel, layout.channels, layout.colours, where)
                           : ChannelChoice{.index = 0};
  const auto volume = std::uint64_t(frame) * layout.frame_stride +
                      std::uint64_t(channel.index.value_or(0)) * layout.channel_stride;
  (stored.compressed ? stored.skip : stored.offset) += volume * wide.bytes();
  auto source = stored_source(wide, stored);
  if (layout.leading == 1) return source;
  const bool of_frames = layout.leading_is == NrrdLayout::Axis::frames;
  return channel_source(std::move(source), layout.grid, layout.leading,
                        of_frames ? ChannelChoice{.index = frame} : channel);
}

}  // namespace

std::unique_ptr<VolumeSource> open_nrrd(const std::filesystem::path& path, const VolumeChoice& choice) {
  const auto header = read_nrrd_header(path);
  const auto layout = nrrd_layout(header);
  std::unique_ptr<VolumeSource> source;
  if (layout.leading > 1 || layout.volumes > 1)
    source = source_of(header, layout, choice);
  else if (header.files.size() > 1)
    source = piece_files_source(layout.grid, header.files, [header](const Grid& grid, const auto& file) {
      return source_in(header, grid, file);
    });
  else
    source = source_in(header, layout.grid, header.files[0]);
  VolumeNotes notes{.frames = layout.frames, .channels = layout.channels};
  if (header.patient) {
    notes.world = World::patient;
    notes.unit = "mm";
  }
  return with_notes(std::move(source), notes);
}

}  // namespace ringsplat::detail
