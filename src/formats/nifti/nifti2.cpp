#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <string_view>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/inflate_stream.hpp"
#include "formats/nifti/nifti_image.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

constexpr std::size_t header_bytes = 540;
using Bytes = std::array<std::byte, header_bytes>;

bool is_gzip(const InputFile& file) {
  std::array<std::byte, 2> start{};
  return file.read_some(0, start) == start.size() && start[0] == std::byte{0x1F} &&
         start[1] == std::byte{0x8B};
}

/// The first bytes of the file, 0 behind its end, or of what it holds compressed; nothing when it has none.
std::optional<Bytes> first_bytes(const InputFile& file) {
  Bytes bytes{};
  if (!is_gzip(file)) {
    if (file.read_some(0, bytes) > sizeof(std::int32_t)) return bytes;
    return {};
  }
  try {
    InflateStream(file, 0).read(bytes);
  } catch (const InputError&) {
    return {};  // NIfTI-1's reader says what is wrong with it
  }
  return bytes;
}

/// Numbers at the offsets that nifti2.h gives.
class Header {
 public:
  Header(const Bytes& bytes, bool big_endian, std::filesystem::path path)
      : bytes_(bytes), big_endian_(big_endian), path_(std::move(path)) {}

  template <class T>
  T at(std::size_t offset) const {
    std::array<std::byte, sizeof(T)> value{};
    std::copy_n(bytes_.begin() + std::ptrdiff_t(offset), sizeof(T), value.begin());
    to_native_order(value, sizeof(T), big_endian_);
    return std::bit_cast<T>(value);
  }
  double real(std::size_t offset) const {
    constexpr double largest = 1e12;  // squares and products stay finite, too
    const auto value = at<double>(offset);
    if (!(std::abs(value) <= largest)) fail("spacing or orientation is not a number");
    return value;
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}: {}", path_.string(), what), "correct the NIfTI-2 header");
  }
  /// dim[i], 1 beyond dim[0].
  int dim(int i) const {
    const auto axes = at<std::int64_t>(16);
    if (axes < 1 || axes > 7) fail(fmt::format("dim[0] is {}", axes));
    if (i > axes) return 1;
    const auto size = at<std::int64_t>(16 + 8 * std::size_t(i));
    if (size < 1 || size > std::numeric_limits<int>::max()) fail(fmt::format("dim[{}] is {}", i, size));
    return int(size);
  }
  double pixdim(std::size_t i) const { return real(104 + 8 * i); }
  bool big_endian() const { return big_endian_; }
  const std::filesystem::path& path() const { return path_; }

 private:
  const Bytes& bytes_;
  bool big_endian_;
  std::filesystem::path path_;
};

const glm::dvec3 to_lps(-1, -1, 1);

/// NIfTI-1 standard, "method 2": a rotation by a unit quaternion, of which a is not stored.
NiftiAffine affine_of_qform(const Header& header, const glm::dvec3& spacing) {
  glm::dvec3 q(header.real(352), header.real(360), header.real(368));
  constexpr double least = 1e-7;  // as in nifti1_io.c
  double a = 1 - glm::dot(q, q);
  if (a < least) {
    q /= glm::length(q);
    a = 0;
  } else {
    a = std::sqrt(a);
  }
  const double b = q.x, c = q.y, d = q.z, mirror = header.pixdim(0) < 0 ? -1 : 1;
  return {glm::dvec3(a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)) * spacing.x,
          glm::dvec3(2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)) * spacing.y,
          glm::dvec3(2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - c * c - b * b) *
              (spacing.z * mirror),
          glm::dvec3(header.real(376), header.real(384), header.real(392))};
}

/// "Method 3", else "method 2", else "method 1" of the standard.
NiftiAffine affine_of(const Header& header) {
  glm::dvec3 spacing(1);
  for (int axis = 0; axis < 3; ++axis)
    if (const double size = header.pixdim(1 + std::size_t(axis)); size > 0) spacing[axis] = size;
  NiftiAffine affine{};
  if (header.at<std::int32_t>(348) > 0) {
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = 0; column < 4; ++column)
        affine[column][int(row)] = header.real(400 + 32 * row + 8 * column);
    return affine;
  }
  if (header.at<std::int32_t>(344) > 0) return affine_of_qform(header, spacing);
  // No orientation: the lattice's axes are the world's, as ITK has it.
  for (int axis = 0; axis < 3; ++axis) affine[std::size_t(axis)][axis] = spacing[axis] * to_lps[axis];
  return affine;
}

Grid grid_of(const Header& header) {
  Grid grid;
  grid.dims = {header.dim(1), header.dim(2), header.dim(3)};
  place_nifti(affine_of(header), header.at<std::int32_t>(500), header.path(), grid);
  return grid;
}

/// Of a .hdr the .img beside it.
std::filesystem::path voxel_file(const std::filesystem::path& path, bool single) {
  if (single) return path;
  auto beside = path;
  std::error_code ignored;
  if (!std::filesystem::exists(beside.replace_extension(".img"), ignored)) beside += ".gz";
  return beside;
}

int vectors_of(const Header& header) {
  std::int64_t vectors = 1;
  for (int axis = 5; axis <= 7; ++axis) {
    vectors *= header.dim(axis);
    if (vectors > std::numeric_limits<int>::max()) header.fail("its axes 5 to 7 are too long");
  }
  return int(vectors);
}

NiftiImage image_of(const Header& header, bool single) {
  NiftiImage image;
  const int code = header.at<std::int16_t>(12);
  const auto [type, colours] = nifti_type(code, fmt::format("{}", code), header.path());
  image.grid = grid_of(header);
  image.grid.type = image.stored.type = type;
  image.colours = colours;
  image.frames = header.dim(4);
  image.vectors = vectors_of(header);
  image.stored.file = voxel_file(header.path(), single);
  image.stored.compressed = is_gzip(InputFile(image.stored.file));
  image.stored.big_endian = header.big_endian();
  const auto offset = header.at<std::int64_t>(168);
  constexpr std::int64_t farthest = std::int64_t{1} << 40;
  if (offset < 0 || offset > farthest || (single && offset < std::int64_t(header_bytes)))
    header.fail(fmt::format("vox_offset is {}", offset));
  (image.stored.compressed ? image.stored.skip : image.stored.offset) = std::uint64_t(offset);
  image.stored.rescale = nifti_rescale(header.at<double>(176), header.at<double>(184));
  return image;
}

}  // namespace

void place_nifti(const NiftiAffine& affine, int xyzt_units, const std::filesystem::path& path, Grid& grid) {
  const double unit = nifti_millimetres(xyzt_units);
  grid.origin = affine[3] * to_lps * unit;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& step = affine[std::size_t(axis)];
    const double length = glm::length(step);
    if (!(length > 0))
      throw InputError(fmt::format("{}: a step along axis {} leads nowhere", path.string(), axis),
                       "correct the orientation in the header");
    grid.spacing[axis] = length * unit;
    grid.direction[axis] = step / length * to_lps;
  }
}

std::optional<NiftiImage> read_nifti2(const std::filesystem::path& path) {
  // Of a pair either file may be named.
  auto header_path = path;
  const auto name = lower_case(path.filename().string());
  if (name.ends_with(".img.gz")) header_path.replace_extension();
  if (name.ends_with(".img") || name.ends_with(".img.gz")) header_path.replace_extension(".hdr");
  std::error_code ignored;
  if (!std::filesystem::exists(header_path, ignored)) return {};
  const auto bytes = first_bytes(InputFile(header_path));
  if (!bytes) return {};
  constexpr std::string_view end_of_magic("\0\r\n\032\n", 5);
  const auto text = std::string_view(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  const bool single = text.substr(4, 3) == "n+2", pair = text.substr(4, 3) == "ni2";
  for (const bool big_endian : {false, true}) {
    const Header header(*bytes, big_endian, header_path);
    if (header.at<std::int32_t>(0) != int(header_bytes)) continue;
    if ((!single && !pair) || text.substr(7, 5) != end_of_magic)
      header.fail("the header has 540 bytes, but not NIfTI-2's signature");
    if (const InputFile file(header_path); !is_gzip(file) && file.size() < header_bytes)
      header.fail("the header is cut short");
    return image_of(header, single);
  }
  return {};
}

}  // namespace ringsplat::detail
