#include <fmt/format.h>
#include <itkMetaImageIO.h>

#include <algorithm>
#include <fstream>

#include "volume/formats.hpp"
#include "volume/input_file.hpp"
#include "volume/itk_image.hpp"
#include "volume/limits.hpp"
#include "volume/stored_source.hpp"

namespace ringsplat::detail {
namespace {

/// MetaIO loops for ever, or writes beyond its arrays, when NDims is not from 1 to 10.
void require_dimension_count(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string line;
  constexpr std::size_t longest_header = 10'000;  // lines; MetaIO's own limit is lower
  for (std::size_t i = 0; i < longest_header && std::getline(stream, line); ++i) {
    const auto equals = line.find_first_of("=:");
    const auto key = one_line(line.substr(0, equals));
    if (key == "ElementDataFile") return;
    if (key != "NDims" || equals == std::string::npos) continue;
    const auto value = one_line(line.substr(equals + 1));
    if (value != "2" && value != "3" && value != "4")
      throw InputError(fmt::format("{}: NDims is '{}'", path.string(), value),
                       "only volumes of 3 dimensions can be rendered");
  }
}

/// The header as MetaIO reads it, and the byte after its last line.
struct MetaHeader {
  MetaImage image;
  std::uint64_t end = 0;

  explicit MetaHeader(const std::filesystem::path& path) {
    require_dimension_count(path);
    std::ifstream stream(path, std::ios::binary);
    constexpr bool read_voxels = false;
    if (!image.ReadStream(0, &stream, read_voxels))
      throw InputError(fmt::format("{} has no readable MetaImage header", path.string()),
                       "it needs NDims, DimSize, ElementType and ElementDataFile");
    for (int i = 0; i < image.NDims(); ++i)
      if (image.DimSize(i) < 1)
        throw InputError(fmt::format("{}: DimSize is {} along axis {}", path.string(), image.DimSize(i), i),
                         "every dimension must be at least 1");
    stream.clear();
    end = std::uint64_t(stream.tellg());
  }
  std::string data_name() const { return image.ElementDataFileName(); }
  bool is_local() const { return data_name() == "LOCAL" || data_name() == "Local" || data_name() == "local"; }
  /// A list of files or a name pattern, one file a slice or so.
  bool several_files() const {
    return data_name().rfind("LIST", 0) == 0 || data_name().find('%') != std::string::npos;
  }
};

std::uint64_t voxel_offset(const MetaHeader& header, std::uint64_t file_bytes, std::uint64_t voxel_bytes) {
  if (header.is_local()) return header.end;
  // -1: the voxels are the last bytes of the file (MetaIO's documentation, "HeaderSize").
  if (header.image.HeaderSize() == -1) return file_bytes - std::min(file_bytes, voxel_bytes);
  return header.image.HeaderSize() > 0 ? std::uint64_t(header.image.HeaderSize()) : 0;
}

}  // namespace

std::unique_ptr<VolumeSource> open_meta(const std::filesystem::path& path) {
  return with_itk(path, [&]() -> std::unique_ptr<VolumeSource> {
    const MetaHeader header(path);
    auto io = itk::MetaImageIO::New();
    io->SetFileName(path.string());
    io->ReadImageInformation();
    const Grid grid = grid_of(*io, path);
    if (header.several_files()) return itk_source(io.GetPointer(), grid, path);

    StoredVoxels stored{.file = header.is_local() ? path : path.parent_path() / header.data_name()};
    const InputFile file(stored.file);
    if (!header.image.BinaryData()) {
      require_numbers(stored.file, header.is_local() ? header.end : 0, std::uint64_t(grid.voxels()));
      return itk_source(io.GetPointer(), grid, path);
    }
    stored.compressed = header.image.CompressedData();
    stored.offset =
        stored.compressed && !header.is_local() ? 0 : voxel_offset(header, file.size(), grid.bytes());
    stored.big_endian = header.image.BinaryDataByteOrderMSB();
    stored.type = grid.type;
    return stored_source(grid, stored);
  });
}

}  // namespace ringsplat::detail
