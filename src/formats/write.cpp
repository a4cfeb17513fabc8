#include "formats/write.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <memory>
#include <new>

#include "base/output_file.hpp"
#include "base/text.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

constexpr bool native_is_big = std::endian::native == std::endian::big;

std::string nrrd_vector(const glm::dvec3& v) { return fmt::format("({},{},{})", v.x, v.y, v.z); }

/// The NRRD0004 header up to the empty line before attached data.
std::string nrrd_header(const Grid& grid, World world, bool gzip, const std::string& data_file) {
  const auto axis = [&](int i) { return nrrd_vector(grid.direction[i] * grid.spacing[i]); };
  std::string text = fmt::format(
      "NRRD0004\ntype: {}\ndimension: 3\nspace{}\nsizes: {} {} {}\n"
      "space directions: {} {} {}\nkinds: domain domain domain\nendian: {}\nencoding: {}\nspace origin: {}\n",
      grid.type == ScalarType::float32   ? "float"
      : grid.type == ScalarType::float64 ? "double"
                                         : to_string(grid.type),
      world == World::patient ? ": left-posterior-superior" : " dimension: 3", grid.dims.x, grid.dims.y,
      grid.dims.z, axis(0), axis(1), axis(2), native_is_big ? "big" : "little", gzip ? "gzip" : "raw",
      nrrd_vector(grid.origin));
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

void write_voxels(VolumeSource& source, OutputFile& file) {
  std::vector<std::byte> slice(source.grid().slice_bytes(Axis::z));
  for (int z = 0; z < source.grid().dims.z; ++z) {
    source.read_slices(z, 1, slice);
    file.write(std::span<const std::byte>(slice));
  }
}

/// As one gzip stream.
void write_compressed(VolumeSource& source, OutputFile& file) {
  constexpr int gzip_header = 15 + 16;  // zlib.h, deflateInit2: largest window, gzip
  constexpr int usual_memory = 8;
  z_stream stream{};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, gzip_header, usual_memory,
                   Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  const std::unique_ptr<z_stream, decltype(&deflateEnd)> ended_at_last(&stream, &deflateEnd);
  std::vector<std::byte> slice(source.grid().slice_bytes(Axis::z)), window(64 * 1024);
  const auto encode = [&](std::span<std::byte> in, int flush) {
    stream.next_in = reinterpret_cast<Bytef*>(in.data());
    stream.avail_in = static_cast<uInt>(in.size());
    do {
      stream.next_out = reinterpret_cast<Bytef*>(window.data());
      stream.avail_out = static_cast<uInt>(window.size());
      deflate(&stream, flush);
      file.write(std::span(window).first(window.size() - stream.avail_out));
    } while (stream.avail_out == 0);
  };
  constexpr std::size_t most = std::numeric_limits<uInt>::max();
  for (int z = 0; z < source.grid().dims.z; ++z) {
    source.read_slices(z, 1, slice);
    for (std::size_t at = 0; at < slice.size(); at += most)
      encode(std::span(slice).subspan(at, std::min(most, slice.size() - at)), Z_NO_FLUSH);
  }
  encode({}, Z_FINISH);
}

/// Begins a file after checking its place, so that later failures are the disk's.
OutputFile begin(const std::filesystem::path& path) {
  check_can_write(path, "the volume");
  return OutputFile(path);
}

void write_attached(VolumeSource& source, const std::filesystem::path& path, bool compress, World world) {
  OutputFile file = begin(path);
  file.write(nrrd_header(source.grid(), world, compress, {}));
  if (compress)
    write_compressed(source, file);
  else
    write_voxels(source, file);
  file.commit();
}

/// Both are on the disk before either gets its name. The voxels get theirs first, so a header is never seen
/// without them.
void write_detached(VolumeSource& source, const std::filesystem::path& path, bool meta, World world) {
  auto data_path = path;
  data_path.replace_extension(".raw");
  const auto name = data_path.filename().string();
  OutputFile header = begin(path), data = begin(data_path);
  header.write(meta ? meta_header(source.grid(), name) : nrrd_header(source.grid(), world, false, name));
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
                   "the name says something else than {} {}", detail::product_of(grid.dims),
                   to_string(grid.type));
  }
  auto tagged = path;
  tagged.replace_filename(fmt::format("{}_{}x{}x{}_{}.raw", path.stem().string(), grid.dims.x, grid.dims.y,
                                      grid.dims.z, to_string(grid.type)));
  return tagged;
}

}  // namespace

std::filesystem::path write_volume(VolumeSource& source, const std::filesystem::path& path, bool compress,
                                   World world) {
  const std::string ending = detail::lower_case(path.extension().string());
  if (ending == ".nrrd") return write_attached(source, path, compress, world), path;
  if (ending == ".nhdr" || ending == ".mhd")
    return write_detached(source, path, ending == ".mhd", world), path;
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
