#pragma once
// Small volume files made at run time, byte by byte, so that they do not depend on the readers' libraries.
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "ringsplat/volume/source.hpp"
#include "support/temporary_folder.hpp"

namespace files {

namespace fs = std::filesystem;
using namespace ringsplat;

/// Its files as paths.
class Folder : public support::TemporaryFolder {
 public:
  fs::path operator/(const std::string& name) const { return path() / name; }
};

inline fs::path write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

inline std::string slurp(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <class T>
std::string bytes_of(const T& value, bool big_endian = false) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (big_endian != (std::endian::native == std::endian::big)) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

inline std::string gzip(const std::string& data) {
  z_stream stream{};
  deflateInit2(&stream, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, data.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
  stream.avail_in = uInt(data.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = uInt(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

inline std::string zlib_stream(const std::string& data) {
  uLongf size = compressBound(data.size());
  std::string out(size, '\0');
  compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(data.data()),
           data.size());
  out.resize(size);
  return out;
}

// The volume that every format is asked for: 5 x 4 x 3 with no symmetry, values that use the type's sign and
// width.
inline constexpr int nx = 5, ny = 4, nz = 3;

template <class T>
T sample(int x, int y, int z) {
  const int n = x + nx * (y + ny * z);
  if constexpr (std::is_floating_point_v<T>)
    return T(n) * T(1.25) - T(20);
  else
    return T((n * 37) % 101 * (sizeof(T) > 1 ? 211 : 1) - (std::is_signed_v<T> ? 50 : 0));
}

template <class T>
std::string samples(bool big_endian = false) {
  std::string bytes;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) bytes += bytes_of(sample<T>(x, y, z), big_endian);
  return bytes;
}

inline std::string read_all(VolumeSource& source) {
  std::string bytes(source.grid().bytes(), '\0');
  source.read_slices(0, source.grid().dims.z, std::as_writable_bytes(std::span(bytes)));
  return bytes;
}

inline std::string read_slice(VolumeSource& source, int z) {
  std::string bytes(source.grid().slice_bytes(Axis::z), '\0');
  source.read_slices(z, 1, std::as_writable_bytes(std::span(bytes)));
  return bytes;
}

/// A NIfTI-1 header of 348 bytes and its empty extension.
struct Nifti {
  short dims[8] = {3, nx, ny, nz, 1, 1, 1, 1};
  short datatype = 4, bits = 16;
  float spacing[3] = {1, 2, 3};
  float slope = 0, intercept = 0;
  float rows[12] = {1, 0, 0, -10, 0, 2, 0, -20, 0, 0, 3, -30};  ///< voxel to RAS world
  const char* magic = "n+1";
  float offset = 352;

  std::string header(bool big_endian = false) const {
    std::string h(352, '\0');
    const auto put = [&](std::size_t at, auto value) {
      const auto bytes = bytes_of(value, big_endian);
      std::copy(bytes.begin(), bytes.end(), h.begin() + std::ptrdiff_t(at));
    };
    put(0, 348);
    for (std::size_t i = 0; i < 8; ++i) put(40 + 2 * i, dims[i]);
    put(70, datatype);
    put(72, bits);
    put(76, 1.0F);
    for (std::size_t i = 0; i < 3; ++i) put(80 + 4 * i, spacing[i]);
    put(108, offset);
    put(112, slope);
    put(116, intercept);
    h[123] = 2;  // millimetres
    put(254, short(1));
    for (std::size_t i = 0; i < 12; ++i) put(280 + 4 * i, rows[i]);
    std::copy(magic, magic + 3, h.begin() + 344);
    return h;
  }
};

/// One DICOM CT slice, explicit VR little endian, 16-bit signed (PS3.5, section 7; PS3.10, section 7).
struct Dicom {
  int columns = nx, rows = ny, number = 1, samples = 1;
  std::string position = "0\\0\\0", orientation = "1\\0\\0\\0\\1\\0", spacing = "2\\1";
  std::string slope = "1", intercept = "0", series = "1.2.3.4.5";
  std::string pixels;

  static std::string element(unsigned group, unsigned id, const char* vr, std::string value) {
    const bool text = std::string("UI OB OW US UL").find(vr) == std::string::npos;
    if (value.size() % 2 != 0) value += text ? ' ' : '\0';
    std::string out = bytes_of(std::uint16_t(group)) + bytes_of(std::uint16_t(id)) + vr;
    if (vr[0] == 'O')
      out += bytes_of(std::uint16_t(0)) + bytes_of(std::uint32_t(value.size()));
    else
      out += bytes_of(std::uint16_t(value.size()));
    return out + value;
  }
  static std::string number16(unsigned group, unsigned id, int value) {
    return element(group, id, "US", bytes_of(std::uint16_t(value)));
  }

  std::string bytes() const {
    const std::string ct = "1.2.840.10008.5.1.4.1.1.2", instance = series + "." + std::to_string(number);
    std::string meta = element(2, 1, "OB", std::string("\0\1", 2)) + element(2, 2, "UI", ct) +
                       element(2, 3, "UI", instance) + element(2, 0x10, "UI", "1.2.840.10008.1.2.1") +
                       element(2, 0x12, "UI", "1.2.3");
    meta = element(2, 0, "UL", bytes_of(std::uint32_t(meta.size()))) + meta;
    return std::string(128, '\0') + "DICM" + meta + element(8, 0x16, "UI", ct) +
           element(8, 0x18, "UI", instance) + element(8, 0x60, "CS", "CT") +
           element(0x10, 0x10, "PN", "Test") + element(0x20, 0xD, "UI", "1.2.3.4") +
           element(0x20, 0xE, "UI", series) + element(0x20, 0x13, "IS", std::to_string(number)) +
           element(0x20, 0x32, "DS", position) + element(0x20, 0x37, "DS", orientation) +
           element(0x20, 0x52, "UI", "1.2.3.9") + number16(0x28, 2, samples) +
           element(0x28, 4, "CS", "MONOCHROME2") + number16(0x28, 0x10, rows) +
           number16(0x28, 0x11, columns) + element(0x28, 0x30, "DS", spacing) + number16(0x28, 0x100, 16) +
           number16(0x28, 0x101, 16) + number16(0x28, 0x102, 15) + number16(0x28, 0x103, 1) +
           element(0x28, 0x1052, "DS", intercept) + element(0x28, 0x1053, "DS", slope) +
           element(0x7FE0, 0x10, "OW", pixels);
  }
};

/// Writes the sample volume's int16 slices as a series; file names run against the order in space.
inline void write_dicom_series(const fs::path& folder, Dicom slice = {}) {
  const auto all = samples<short>();
  const auto slice_bytes = std::size_t(nx * ny) * sizeof(short);
  for (int z = 0; z < nz; ++z) {
    slice.number = z + 1;
    slice.position = "-10\\-20\\" + std::to_string(-30 + 3 * z);
    slice.pixels = all.substr(std::size_t(z) * slice_bytes, slice_bytes);
    write(folder / ("image" + std::to_string(nz - z) + ".dcm"), slice.bytes());
  }
}

}  // namespace files
