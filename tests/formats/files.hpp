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

#include "ringsplat/formats/open.hpp"
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

/// Without any header (RFC 1951).
inline std::string deflated(const std::string& data) {
  const auto packed = gzip(data);  // a header of 10 bytes, and 8 at the end
  return packed.substr(10, packed.size() - 18);
}

inline std::string zlib_stream(const std::string& data) {
  uLongf size = compressBound(data.size());
  std::string out(size, '\0');
  compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(data.data()),
           data.size());
  out.resize(size);
  return out;
}

// The sample volume of every format: 5 x 4 x 3, without symmetry; its values use the type's sign and width.
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

inline std::string samples_of(ScalarType type, bool big_endian = false) {
  return visit_type(type, [&](auto zero) { return samples<decltype(zero)>(big_endian); });
}

inline std::string text_of_samples() {
  std::string text;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) text += std::to_string(sample<short>(x, y, z)) + (x + 1 < nx ? " " : "\n");
  return text;
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

inline std::string voxels_of(const fs::path& path, const VolumeChoice& choice = {}) {
  return read_all(*open_volume(path, {}, choice));
}

inline std::string slice_of_samples(int z, bool big_endian = false) {
  return samples<short>(big_endian).substr(std::size_t(z) * 40, 40);
}

/// Whether it is the sample volume of int16, whole and slice by slice in another order.
inline bool is_sample(VolumeSource& source) {
  const Grid& grid = source.grid();
  bool same = grid.dims == glm::ivec3(nx, ny, nz) && grid.type == ScalarType::int16 &&
              read_all(source) == samples<short>();
  for (const int z : {2, 0, 1, 1, 0}) same = same && read_slice(source, z) == slice_of_samples(z);
  return same;
}

/// The sample volume as number `at` of `count` in each voxel.
inline std::string interleaved(int count, int at, bool big_endian = false) {
  std::string voxels;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x)
        for (int i = 0; i < count; ++i)
          voxels += bytes_of(i == at ? sample<short>(x, y, z) : short(1000 + i), big_endian);
  return voxels;
}

inline glm::dvec3 world(const Grid& grid, const glm::dvec3& voxel) {
  return grid.origin + grid.direction * (grid.spacing * voxel);
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

/// One DICOM CT image, 16-bit signed and in explicit VR little endian unless said otherwise (PS3.5, section
/// 7; PS3.10, section 7).
struct Dicom {
  int columns = nx, rows = ny, number = 1, samples = 1;
  int bits = 16, stored = 0, high_bit = -1,
      frames = 0;  ///< stored and high bit follow from bits; 0 frames: left out
  bool is_signed = true;
  std::string position = "0\\0\\0", orientation = "1\\0\\0\\0\\1\\0", spacing = "2\\1";
  std::string slope = "1", intercept = "0", series = "1.2.3.4.5", photometric = "MONOCHROME2";
  std::string syntax = "1.2.840.10008.1.2.1", storage_class = "1.2.840.10008.5.1.4.1.1.2";
  std::string more;                    ///< encoded elements between the others and the pixels
  std::string pixels;                  ///< little endian
  std::vector<std::string> fragments;  ///< instead of pixels; the first is the offset table

  /// A value in text, or in little-endian binary.
  static std::string element(unsigned group, unsigned id, const std::string& vr, std::string value,
                             const std::string& syntax = "1.2.840.10008.1.2.1") {
    const bool implicit = syntax == "1.2.840.10008.1.2", big = syntax == "1.2.840.10008.1.2.2";
    const bool text = std::string("UI OB OW US UL FD SQ").find(vr) == std::string::npos;
    if (value.size() % 2 != 0) value += text ? ' ' : '\0';
    if (big && (vr == "US" || vr == "UL")) std::reverse(value.begin(), value.end());
    if (big && vr == "OW")
      for (std::size_t i = 0; i < value.size(); i += 2) std::swap(value[i], value[i + 1]);
    std::string out = bytes_of(std::uint16_t(group), big) + bytes_of(std::uint16_t(id), big);
    if (implicit) return out + bytes_of(std::uint32_t(value.size())) + value;
    out += vr;
    if (vr[0] == 'O' || vr == "SQ")
      out += bytes_of(std::uint16_t(0)) + bytes_of(std::uint32_t(value.size()), big);
    else
      out += bytes_of(std::uint16_t(value.size()), big);
    return out + value;
  }
  static std::string item(const std::string& value) {
    return bytes_of(std::uint16_t(0xFFFE)) + bytes_of(std::uint16_t(0xE000)) +
           bytes_of(std::uint32_t(value.size())) + value;
  }
  static std::string sequence(unsigned group, unsigned id, const std::vector<std::string>& items) {
    std::string all;
    for (const auto& one : items) all += item(one);
    return element(group, id, "SQ", all);
  }

  std::string meta() const {
    const std::string instance = series + "." + std::to_string(number);
    const std::string meta = element(2, 1, "OB", std::string("\0\1", 2)) +
                             element(2, 2, "UI", storage_class) + element(2, 3, "UI", instance) +
                             element(2, 0x10, "UI", syntax) + element(2, 0x12, "UI", "1.2.3");
    return std::string(128, '\0') + "DICM" + element(2, 0, "UL", bytes_of(std::uint32_t(meta.size()))) + meta;
  }

  std::string pixel_element() const {
    if (fragments.empty()) return element(0x7FE0, 0x10, bits == 8 ? "OB" : "OW", pixels, syntax);
    std::string out = bytes_of(std::uint16_t(0x7FE0)) + bytes_of(std::uint16_t(0x10)) + "OB" +
                      bytes_of(std::uint16_t(0)) + bytes_of(std::uint32_t(0xFFFFFFFF));
    for (const auto& fragment : fragments) out += item(fragment.size() % 2 == 0 ? fragment : fragment + '\0');
    return out + bytes_of(std::uint16_t(0xFFFE)) + bytes_of(std::uint16_t(0xE0DD)) +
           bytes_of(std::uint32_t(0));
  }

  std::string bytes() const {
    std::string out;
    const auto add = [&](unsigned group, unsigned id, const char* vr, const std::string& value) {
      out += element(group, id, vr, value, syntax);
    };
    const auto add16 = [&](unsigned group, unsigned id, int value) {
      add(group, id, "US", bytes_of(std::uint16_t(value)));
    };
    const auto add_text = [&](unsigned group, unsigned id, const char* vr, const std::string& value) {
      if (!value.empty()) add(group, id, vr, value);
    };
    const int used = stored > 0 ? stored : bits;
    add(8, 0x16, "UI", storage_class);
    add(8, 0x18, "UI", series + "." + std::to_string(number));
    add(8, 0x60, "CS", "CT");
    add(0x10, 0x10, "PN", "Test");
    add(0x20, 0xD, "UI", "1.2.3.4");
    add(0x20, 0xE, "UI", series);
    add(0x20, 0x13, "IS", std::to_string(number));
    add_text(0x20, 0x32, "DS", position);
    add_text(0x20, 0x37, "DS", orientation);
    add(0x20, 0x52, "UI", "1.2.3.9");
    add16(0x28, 2, samples);
    add(0x28, 4, "CS", photometric);
    if (frames != 0) add(0x28, 8, "IS", std::to_string(frames));
    add16(0x28, 0x10, rows);
    add16(0x28, 0x11, columns);
    add_text(0x28, 0x30, "DS", spacing);
    add16(0x28, 0x100, bits);
    add16(0x28, 0x101, used);
    add16(0x28, 0x102, high_bit >= 0 ? high_bit : used - 1);
    add16(0x28, 0x103, is_signed ? 1 : 0);
    add_text(0x28, 0x1052, "DS", intercept);
    add_text(0x28, 0x1053, "DS", slope);
    out += more + pixel_element();
    return meta() + (syntax == "1.2.840.10008.1.2.1.99" ? deflated(out) : out);
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
