#include <fmt/format.h>
#include <itkNrrdImageIO.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>

#include "base/input_file.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/itk_image.hpp"
#include "formats/limits.hpp"
#include "formats/nrrd/files.hpp"
#include "formats/nrrd/layout.hpp"
#include "formats/stored_source.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

/// NrrdIO, the format's own library, reads the header and stops at the first byte of the voxels.
class NrrdHeader {
 public:
  explicit NrrdHeader(const std::filesystem::path& path)
      : path_(path), nrrd_(nrrdNew()), io_(nrrdIoStateNew()) {
    nrrdIoStateSet(io_, nrrdIoStateSkipData, 1);
    nrrdIoStateSet(io_, nrrdIoStateKeepNrrdDataFileOpen, 1);
    if (nrrdLoad(nrrd_, path.c_str(), io_) != 0) {
      const std::string problem = take_error();
      // NrrdIO closes the header's own file, but not one that the header names.
      if (!names_data_files()) io_->dataFile = nullptr;
      release();
      throw InputError(fmt::format("{} is not a readable NRRD file: {}", path.string(), problem),
                       "see teem.sourceforge.net/nrrd for the format");
    }
  }
  ~NrrdHeader() { release(); }
  NrrdHeader(const NrrdHeader&) = delete;
  NrrdHeader& operator=(const NrrdHeader&) = delete;

  const NrrdIoState& io() const { return *io_; }
  const Nrrd& nrrd() const { return *nrrd_; }
  /// ITK keeps the low 32 bits of a larger size.
  void require_sizes_of_int() const {
    for (unsigned i = 0; i < nrrd_->dim; ++i)
      if (nrrd_->axis[i].size > std::size_t(std::numeric_limits<int>::max()))
        throw InputError(fmt::format("{}: {} voxels along axis {}", path_.string(), nrrd_->axis[i].size, i),
                         "correct the sizes in the header");
  }
  /// Of the spaces that NRRD knows, those of a patient come first (nrrdEnums.h).
  VolumeNotes notes() const {
    const bool patient =
        nrrd_->space > nrrdSpaceUnknown && nrrd_->space <= nrrdSpaceLeftPosteriorSuperiorTime;
    return patient ? VolumeNotes{.world = World::patient, .unit = "mm"} : VolumeNotes{};
  }
  bool is_left_anterior() const {
    return nrrd_->space == nrrdSpaceLeftAnteriorSuperior || nrrd_->space == nrrdSpaceLeftAnteriorSuperiorTime;
  }
  bool is_nrrd() const { return io_->format == nrrdFormatNRRD; }
  bool names_data_files() const { return io_->dataFNFormat != nullptr || io_->dataFNArr->len > 0; }
  bool several_files() const { return io_->dataFNFormat != nullptr || io_->dataFNArr->len > 1; }
  /// The first byte of the voxels or of the compressed stream, after the skipped lines and bytes.
  std::uint64_t offset() const {
    return io_->dataFile != nullptr ? std::uint64_t(std::ftell(io_->dataFile)) : 0;
  }

  std::filesystem::path data_file() const {
    if (io_->dataFNArr->len == 0) return path_;
    return path_.parent_path() / io_->dataFN[0];
  }

 private:
  /// The innermost message of NrrdIO's stack, which is the last line.
  static std::string take_error() {
    char* text = biffGetDone("nrrd");
    if (text == nullptr) return "damaged header";
    std::string message(text);
    std::free(text);
    while (!message.empty() && message.back() == '\n') message.pop_back();
    message = message.substr(message.rfind('\n') + 1);
    const auto prefix = message.find(": ");
    return one_line(prefix == std::string::npos ? message : message.substr(prefix + 2));
  }

  void release() {
    if (io_->dataFile != nullptr) std::fclose(io_->dataFile);
    io_->dataFile = nullptr;
    nrrdIoStateNix(io_);
    nrrdNix(nrrd_);
  }

  std::filesystem::path path_;
  Nrrd* nrrd_;
  NrrdIoState* io_;
};

/// Throws InputError unless the files can hold the voxels.
void require_files(const std::filesystem::path& path, const NrrdIoState& io, const Grid& grid) {
  std::uint64_t compressed = 0;
  for_data_files(path, io, [&](const std::filesystem::path& file, std::uint64_t files) {
    const auto size = InputFile(file).size();
    if (io.encoding == nrrdEncodingRaw)
      require_bytes(file, size, 0, grid.bytes() / files);
    else if (io.encoding == nrrdEncodingHex)
      require_bytes(file, size, 0, 2 * (grid.bytes() / files));
    else if (io.encoding == nrrdEncodingAscii)
      require_numbers(file, 0, std::uint64_t(grid.voxels()) / files);
    compressed += size;
  });
  require_compressed_bytes(path, compressed, grid.bytes(), deflate_best_ratio);
}

bool is_stored(const NrrdHeader& header) {
  const auto* encoding = header.io().encoding;
  return !header.several_files() && (encoding == nrrdEncodingGzip || encoding == nrrdEncodingRaw);
}

/// The voxels of one file, raw or gzip.
StoredVoxels stored_of(const NrrdHeader& header, ScalarType type, const std::filesystem::path& path) {
  const bool gzip = header.io().encoding == nrrdEncodingGzip;
  if (gzip && header.io().byteSkip < 0)
    throw InputError(fmt::format("{}: 'byte skip: -1' in compressed data", path.string()),
                     "give the number of bytes");
  StoredVoxels stored{.file = header.data_file(), .offset = header.offset(), .compressed = gzip};
  stored.skip = gzip ? std::uint64_t(header.io().byteSkip) : 0;
  stored.big_endian = header.io().endian == airEndianBig;
  stored.type = type;
  return stored;
}

/// The voxels, which the header describes.
std::unique_ptr<VolumeSource> source_of(const NrrdHeader& header, itk::NrrdImageIO& io, const Grid& grid,
                                        const std::filesystem::path& path) {
  if (header.several_files()) {
    require_files(path, header.io(), grid);
    return itk_source(&io, grid, path);
  }
  if (is_stored(header)) return stored_source(grid, stored_of(header, grid.type, path));
  const auto* encoding = header.io().encoding;
  if (encoding == nrrdEncodingAscii)
    require_numbers(header.data_file(), header.offset(), std::uint64_t(grid.voxels()));
  else if (encoding == nrrdEncodingHex)
    require_bytes(header.data_file(), InputFile(header.data_file()).size(), header.offset(),
                  2 * grid.bytes());
  else
    throw InputError(fmt::format("{}: encoding '{}' cannot be read", path.string(), encoding->name),
                     "write it anew with encoding gzip or raw");
  return itk_source(&io, grid, path);
}

/// One frame and channel of a volume with axes of those.
std::unique_ptr<VolumeSource> source_of(const NrrdHeader& header, const NrrdLayout& layout,
                                        const VolumeChoice& choice, const std::filesystem::path& path) {
  if (!is_stored(header))
    throw InputError(
        fmt::format("{}: several volumes or components as {}", path.string(),
                    header.several_files() ? "several files"
                                           : fmt::format("encoding '{}'", header.io().encoding->name)),
        "write it anew in one file with encoding gzip or raw");
  const auto wide = interleaved_grid(layout.grid, layout.leading, path.string());
  auto stored = stored_of(header, wide.type, path);
  const auto before = stored.compressed ? stored.skip : stored.offset;
  const auto total = bytes_of_volumes(path, wide.bytes(), layout.volumes, before);
  const auto size = InputFile(stored.file).size();
  if (stored.compressed)
    require_compressed_bytes(stored.file, size, total, deflate_best_ratio);
  else
    require_bytes(stored.file, size, before, total - before);

  const int frame = std::clamp(choice.frame.value_or(0), 0, layout.frames - 1);
  const auto channel = layout.channels > 1
                           ? choose_channel(choice.channel, layout.channels, layout.colours, path.string())
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
  return with_itk(path, [&]() -> std::unique_ptr<VolumeSource> {
    require_nrrdio_can_read(path);
    const NrrdHeader header(path);
    if (!header.is_nrrd())
      throw InputError(fmt::format("{} does not begin with the letters NRRD", path.string()),
                       "rename it to its own format's ending");
    header.require_sizes_of_int();
    if (const auto layout = nrrd_layout(header.nrrd(), path)) {
      auto notes = header.notes();
      notes.frames = layout->frames;
      notes.channels = layout->channels;
      return with_notes(source_of(header, *layout, choice, path), notes);
    }
    auto io = itk::NrrdImageIO::New();
    io->SetFileName(path.string());
    io->ReadImageInformation();
    Grid grid = grid_of(*io, path);
    if (header.is_left_anterior()) grid = nrrd_grid(header.nrrd(), path);
    return with_notes(source_of(header, *io, grid, path), header.notes());
  });
}

}  // namespace ringsplat::detail
