#include "formats/write.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <new>
#include <span>
#include <string>
#include <vector>

#include "base/output_file.hpp"
#include "base/text.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/meta/types.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

constexpr bool native_is_big = std::endian::native == std::endian::big;

std::string nrrd_vector(const glm::dvec3& v) { return fmt::format("({},{},{})", v.x, v.y, v.z); }

/// The NRRD0004 header up to the empty line before attached data.
std::string nrrd_header(const Grid& grid, bool gzip, const std::string& data_file) {
  const auto axis = [&](int i) { return nrrd_vector(grid.direction[i] * grid.spacing[i]); };
  std::string text = fmt::format(
      "NRRD0004\ntype: {}\ndimension: 3\nspace: left-posterior-superior\nsizes: {} {} {}\n"
      "space directions: {} {} {}\nkinds: domain domain domain\nendian: {}\nencoding: {}\nspace origin: {}\n",
      grid.type == ScalarType::float32   ? "float"
      : grid.type == ScalarType::float64 ? "double"
                                         : to_string(grid.type),
      grid.dims.x, grid.dims.y, grid.dims.z, axis(0), axis(1), axis(2), native_is_big ? "big" : "little",
      gzip ? "gzip" : "raw", nrrd_vector(grid.origin));
  return data_file.empty() ? text + "\n" : text + "data file: " + data_file + "\n";
}

std::string meta_header(const Grid& grid, const std::string& data_file) {
  std::string matrix;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) matrix += fmt::format(" {}", grid.direction[i][j]);
  return fmt::format(
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = {}\nCompressedData = "
      "False\n"
      "TransformMatrix ={}\nOffset = {} {} {}\nElementSpacing = {} {} {}\nDimSize = {} {} {}\n"
      "ElementType = {}\nElementDataFile = {}\n",
      native_is_big ? "True" : "False", matrix, grid.origin.x, grid.origin.y, grid.origin.z, grid.spacing.x,
      grid.spacing.y, grid.spacing.z, grid.dims.x, grid.dims.y, grid.dims.z,
      detail::meta_types[std::size_t(grid.type)], data_file);
}

/// Appends one gzip stream to a file, which must outlive it.
class DeflateStream {
 public:
  explicit DeflateStream(OutputFile& file) : file_(file), window_(window_bytes) {
    constexpr int gzip_header = 15 + 16;  // zlib.h, deflateInit2: largest window, gzip
    constexpr int usual_memory = 8;
    if (deflateInit2(&stream_, Z_DEFAULT_COMPRESSION, Z_DEFLATED, gzip_header, usual_memory,
                     Z_DEFAULT_STRATEGY) != Z_OK)
      throw std::bad_alloc();
  }
  ~DeflateStream() { deflateEnd(&stream_); }
  DeflateStream(const DeflateStream&) = delete;
  DeflateStream& operator=(const DeflateStream&) = delete;

  /// Throws RunError as OutputFile does.
  void write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const auto part = std::min<std::size_t>(bytes.size(), std::numeric_limits<uInt>::max());
      // zlib.h declares what it only reads without const.
      stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(bytes.data()));
      stream_.avail_in = static_cast<uInt>(part);
      encode(Z_NO_FLUSH);
      bytes = bytes.subspan(part);
    }
  }
  /// The stream's end and checksum.
  void finish() { encode(Z_FINISH); }

 private:
  static constexpr std::size_t window_bytes = 64 * 1024;

  void encode(int flush) {
    do {
      stream_.next_out = reinterpret_cast<Bytef*>(window_.data());
      stream_.avail_out = static_cast<uInt>(window_.size());
      deflate(&stream_, flush);
      file_.write(std::span(window_).first(window_.size() - stream_.avail_out));
    } while (stream_.avail_out == 0);
  }

  OutputFile& file_;
  z_stream stream_{};
  std::vector<std::byte> window_;
};

/// `out` has a write() that takes slices.
template <class Out>
void write_voxels(VolumeSource& source, Out& out) {
  std::vector<std::byte> slice(source.grid().slice_bytes(Axis::z));
  for (int z = 0; z < source.grid().dims.z; ++z) {
    source.read_slices(z, 1, slice);
    out.write(std::span<const std::byte>(slice));
  }
}

/// Begins a file after checking its place, so that later failures are the disk's.
OutputFile begin(const std::filesystem::path& path) {
  check_can_write(path, "the volume");
  return OutputFile(path);
}

void write_attached(VolumeSource& source, const std::filesystem::path& path, bool compress) {
  OutputFile file = begin(path);
  file.write(nrrd_header(source.grid(), compress, {}));
  if (compress) {
    DeflateStream stream(file);
    write_voxels(source, stream);
    stream.finish();
  } else {
    write_voxels(source, file);
  }
  file.commit();
}

/// Both are on the disk before either gets its name. The voxels get theirs first, so a header is never seen
/// without them.
void write_detached(VolumeSource& source, const std::filesystem::path& path, bool meta) {
  auto data_path = path;
  data_path.replace_extension(".raw");
  const auto name = data_path.filename().string();
  OutputFile header = begin(path), data = begin(data_path);
  header.write(meta ? meta_header(source.grid(), name) : nrrd_header(source.grid(), false, name));
  write_voxels(source, data);
  header.secure();
  data.secure();
  data.commit();
  header.commit();
}

/// `path` with the grid's tag in its name; a tag that contradicts the grid is an error.
std::filesystem::path raw_path(const Grid& grid, const std::filesystem::path& path) {
  if (const auto named = detail::parse_raw_name(path)) {
    if (named->dims == grid.dims && named->type == grid.type) return path;
    detail::refuse(path, "leave sizes and type out of the name, they are added",
                   "the name says something else than {} x {} x {} {}", grid.dims.x, grid.dims.y, grid.dims.z,
                   to_string(grid.type));
  }
  auto tagged = path;
  tagged.replace_filename(fmt::format("{}_{}x{}x{}_{}.raw", path.stem().string(), grid.dims.x, grid.dims.y,
                                      grid.dims.z, to_string(grid.type)));
  return tagged;
}

}  // namespace

std::filesystem::path write_volume(VolumeSource& source, const std::filesystem::path& path, bool compress) {
  const std::string ending = detail::lower_case(path.extension().string());
  if (ending == ".nrrd") return write_attached(source, path, compress), path;
  if (ending == ".nhdr" || ending == ".mhd") return write_detached(source, path, ending == ".mhd"), path;
  if (ending != ".raw")
    throw InputError(fmt::format("cannot write {}: unknown ending '{}'", path.string(), ending),
                     "use .nrrd, .nhdr, .mhd or .raw");
  const auto tagged = raw_path(source.grid(), path);
  OutputFile file = begin(tagged);
  write_voxels(source, file);
  file.commit();
  return tagged;
}

}  // namespace ringsplat
