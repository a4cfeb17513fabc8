#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/encoded_bytes.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

/// What matters here of a NIfTI-1 header of 348 bytes (nifti1.h), a NIfTI-2 header of 540 (nifti2.h), or an
/// Analyze 7.5 header, which has NIfTI-1's first fields.
struct NiftiHeader {
  std::filesystem::path path;
  int version = 1;     ///< 0: Analyze
  bool single = true;  ///< the voxels are in the header's own file
  bool big_endian = false;
  std::array<std::int64_t, 8> dims{};  ///< of x, y, z, time and three more from 1 on; 1 for those it has not
  int datatype = 0;
  std::array<double, 4> spacing{};  ///< of x, y, z from 1 on; the first: less than 0 mirrors the qform's z
  std::int64_t offset = 0;          ///< of the voxels in their file
  double slope = 0, intercept = 0;
  int units = 0, qform = 0, sform = 0;
  std::array<double, 3> quaternion{}, shift{};
  std::array<std::array<double, 4>, 3> rows{};

  [[noreturn]] void fail(const std::string& what) const {
    refuse(path, fmt::format("correct the NIfTI-{} header", std::max(1, version)), "{}", what);
  }
};

constexpr std::size_t bytes_of_version[] = {348, 348, 540};

/// Where the versions have their fields.
struct Places {
  std::size_t dims, datatype, spacing, offset, slope, intercept, units, qform, sform, quaternion, shift, rows;
};
constexpr Places places_1{40, 70, 76, 108, 112, 116, 123, 252, 254, 256, 268, 280};
constexpr Places places_2{16, 12, 104, 168, 176, 184, 500, 344, 348, 352, 376, 400};

[[noreturn]] void fail_no_header(const std::filesystem::path& path, const std::string& why) {
  throw InputError(fmt::format("{} has no readable NIfTI header: {}", path.string(), why),
                   "it needs a NIfTI header of 348 or 540 bytes, and an .img file its .hdr");
}

/// Of a pair either file may be named.
std::filesystem::path header_file(const std::filesystem::path& path) {
  const auto name = lower_case(path.filename().string());
  if (!name.ends_with(".img") && !name.ends_with(".img.gz")) return path;
  auto beside = path;
  if (name.ends_with(".gz")) beside.replace_extension();
  const bool capitals = beside.extension() == ".IMG";
  return beside.replace_extension(capitals ? ".HDR" : ".hdr");
}

bool says_version_2(std::span<const std::byte> bytes, bool big_endian) {
  return bytes.size() > sizeof(std::int32_t) &&
         BinaryFields(bytes, big_endian).at<std::int32_t>(0) == int(bytes_of_version[2]);
}

/// The header's bytes, of what the file holds compressed where it is.
std::vector<std::byte> header_bytes(const std::filesystem::path& path) {
  std::vector<std::byte> bytes(bytes_of_version[2]);
  const auto stored = stored_in(path);
  if (stored.encoding == Encoding::raw) {
    bytes.resize(InputFile(path).read_some(0, bytes));
    return bytes;
  }
  bytes.resize(bytes_of_version[1]);
  stored.read_head(bytes);
  if (!says_version_2(bytes, false) && !says_version_2(bytes, true)) return bytes;
  bytes.resize(bytes_of_version[2]);
  stored.read_head(bytes);
  return bytes;
}

template <class Integer, class Code, class Unit, class Real>
void read_fields(const BinaryFields& in, const Places& at, NiftiHeader& header) {
  for (std::size_t i = 0; i < 8; ++i) header.dims[i] = in.at<Integer>(at.dims + i * sizeof(Integer));
  header.datatype = in.at<std::int16_t>(at.datatype);
  const auto reals = [&](std::size_t begin, auto& list) {
    for (std::size_t i = 0; i < list.size(); ++i) list[i] = double(in.at<Real>(begin + i * sizeof(Real)));
  };
  reals(at.spacing, header.spacing);
  if (header.version == 0) return;
  header.slope = double(in.at<Real>(at.slope));
  header.intercept = double(in.at<Real>(at.intercept));
  header.units = in.at<Unit>(at.units);
  header.qform = in.at<Code>(at.qform);
  header.sform = in.at<Code>(at.sform);
  reals(at.quaternion, header.quaternion);
  reals(at.shift, header.shift);
  for (std::size_t row = 0; row < 3; ++row) reals(at.rows + row * 4 * sizeof(Real), header.rows[row]);
}

void check_dims(NiftiHeader& header) {
  const auto axes = header.dims[0];
  if (axes < 1 || axes > 7) header.fail(fmt::format("dim[0] is {}, no NIfTI header", axes));
  for (std::size_t i = 1; i < header.dims.size(); ++i) {
    auto& size = header.dims[i];
    if (std::int64_t(i) > axes) size = 1;
    if (size < 1 || size > std::numeric_limits<int>::max())
      header.fail(fmt::format("dim[{}] is {}", i, size));
  }
}

void read_version_1(std::span<const std::byte> bytes, NiftiHeader& header) {
  if (bytes.size() < bytes_of_version[1]) fail_no_header(header.path, "it has fewer bytes");
  const auto magic = std::string_view(reinterpret_cast<const char*>(bytes.data()) + 344, 4);
  const std::string_view single("n+1", 4), pair("ni1", 4);
  header.version = magic == single || magic == pair ? 1 : 0;
  header.single = magic == single;
  // Its own size is wrong in some files; the number of dimensions is what tells the byte order.
  const auto axes = BinaryFields(bytes, true).at<std::int16_t>(places_1.dims);
  header.big_endian = axes >= 1 && axes <= 7;
  const BinaryFields in(bytes, header.big_endian);
  read_fields<std::int16_t, std::int16_t, std::int8_t, float>(in, places_1, header);
  check_dims(header);
  const auto offset = in.at<float>(places_1.offset);
  constexpr float farthest = 1e12F;
  if (!(std::abs(offset) <= farthest)) header.fail("vox_offset is not a number");
  // Files of one part begin behind their header, whatever they say.
  header.offset = std::max<std::int64_t>(std::int64_t(offset), header.single ? 348 : 0);
}

void read_version_2(std::span<const std::byte> bytes, NiftiHeader& header) {
  header.version = 2;
  if (bytes.size() < bytes_of_version[2]) header.fail("the header is cut short");
  const auto magic = std::string_view(reinterpret_cast<const char*>(bytes.data()) + 4, 8);
  header.single = magic == std::string_view("n+2\0\r\n\032\n", 8);
  if (!header.single && magic != std::string_view("ni2\0\r\n\032\n", 8))
    header.fail("the header has 540 bytes, but not NIfTI-2's signature");
  const BinaryFields in(bytes, header.big_endian);
  read_fields<std::int64_t, std::int32_t, std::int32_t, double>(in, places_2, header);
  check_dims(header);
  header.offset = in.at<std::int64_t>(places_2.offset);
  constexpr std::int64_t farthest = std::int64_t{1} << 40;
  const std::int64_t nearest = header.single ? std::int64_t(bytes_of_version[2]) : 0;
  if (header.offset < nearest || header.offset > farthest)
    header.fail(fmt::format("vox_offset is {}", header.offset));
}

/// Columns: where a step along x, y, z leads, and where voxel 0 is; in the header's unit, right, anterior,
/// superior.
using Affine = std::array<glm::dvec3, 4>;

double real(const NiftiHeader& header, double value) {
  constexpr double largest = 1e12;  // squares and products stay finite, too
  if (!(std::abs(value) <= largest)) header.fail("spacing, offset or orientation is not a number");
  return value;
}

/// A missing one is 1, and so are those of axes that the header does not have.
glm::dvec3 spacing_of(const NiftiHeader& header) {
  glm::dvec3 spacing(1);
  for (std::size_t i = 1; i <= 3 && std::int64_t(i) <= header.dims[0]; ++i) {
    const double size = header.spacing[i];
    if (size < 0) header.fail(fmt::format("pixdim[{}] is {}", i, size));
    if (size > 0) spacing[int(i) - 1] = size;
  }
  return spacing;
}

/// NIfTI-1 standard, "method 3".
Affine affine_of_sform(const NiftiHeader& header) {
  Affine affine{};
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 4; ++column)
      affine[column][int(row)] = real(header, header.rows[row][column]);
  return affine;
}

/// As a NIfTI-1 header would hold it. Through memory, as GCC 12 leaves out half of such conversions when it
/// vectorises them.
double as_float(double value) {
  const volatile float kept = float(value);
  return double(kept);
}

/// "Method 2": a rotation by a unit quaternion, of which a is not stored.
Affine affine_of_qform(const NiftiHeader& header, const glm::dvec3& spacing) {
  glm::dvec3 q, shift;
  for (int i = 0; i < 3; ++i) {
    q[i] = real(header, header.quaternion[std::size_t(i)]);
    shift[i] = real(header, header.shift[std::size_t(i)]);
  }
  constexpr double least = 1e-7;  // as in nifti1_io.c
  double a = 1 - glm::dot(q, q);
  if (a < least) {
    q /= glm::length(q);
    a = 0;
  } else {
    a = std::sqrt(a);
  }
  const double b = q.x, c = q.y, d = q.z, mirror = header.spacing[0] < 0 ? -1 : 1;
  const glm::dvec3 steps(spacing.x, spacing.y, spacing.z * mirror);
  const double turn[3][3] = {{a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c)},
                             {2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b)},
                             {2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - c * c - b * b}};
  Affine affine{};
  affine[3] = shift;
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) {
      const double step = turn[column][row] * steps[column];
      // NIfTI-1's own library rounds the steps.
      affine[std::size_t(column)][row] = header.version == 2 ? step : as_float(step);
    }
  return affine;
}

/// Of the header's unit of length; 1 when it names none.
double millimetres(const NiftiHeader& header) {
  constexpr int metre = 1, micron = 3;
  const int space = header.units & 7;
  return space == metre ? 1e3 : space == micron ? 1e-3 : 1;
}

void place(const NiftiHeader& header, const Affine& affine, Grid& grid) {
  const glm::dvec3 to_lps(-1, -1, 1);
  const double unit = millimetres(header);
  grid.origin = affine[3] * to_lps * unit;
  for (int axis = 0; axis < 3; ++axis) {
    const auto& step = affine[std::size_t(axis)];
    const double length = glm::length(step);
    if (!(length > 0)) header.fail(fmt::format("a step along axis {} leads nowhere", axis));
    grid.spacing[axis] = length * unit;
    grid.direction[axis] = step / length * to_lps;
  }
}

/// Of the file itself, or of the .hdr beside an .img or .img.gz. Throws InputError when there is none, and
/// for impossible dimensions and offsets.
NiftiHeader read_nifti_header(const std::filesystem::path& path) {
  NiftiHeader header;
  header.path = header_file(path);
  if (std::error_code ignored; !std::filesystem::exists(header.path, ignored))
    fail_no_header(path, header.path.filename().string() + " is missing");
  const auto bytes = header_bytes(header.path);
  for (const bool big_endian : {false, true}) {
    header.big_endian = big_endian;
    if (says_version_2(bytes, big_endian)) {
      read_version_2(bytes, header);
      return header;
    }
  }
  read_version_1(bytes, header);
  return header;
}

/// Where the sform puts the voxels, sheared too; else the qform; else as the lattice's axes are the world's.
/// In millimetres, left, posterior, superior. Without the type. Throws InputError when a step leads nowhere.
Grid nifti_grid(const NiftiHeader& header) {
  Grid grid;
  grid.dims = {int(header.dims[1]), int(header.dims[2]), int(header.dims[3])};
  for (const double size : header.spacing) real(header, size);
  if (header.sform > 0) {
    place(header, affine_of_sform(header), grid);
    return grid;
  }
  const auto spacing = spacing_of(header);
  grid.spacing = spacing * millimetres(header);
  if (header.qform <= 0) return grid;
  const auto exact = grid.spacing;
  place(header, affine_of_qform(header, spacing), grid);
  if (header.version < 2) grid.spacing = exact;  // more so than the rounded steps
  return grid;
}

struct Voxel {
  ScalarType type = ScalarType::uint8;
  int colours = 1;  ///< numbers in a voxel: 3 of RGB24, 4 of RGBA32
};

/// By the datatype's code (nifti1.h).
Voxel voxel_of(const NiftiHeader& header) {
  constexpr std::pair<int, Voxel> voxels[] = {{2, {ScalarType::uint8}},    {4, {ScalarType::int16}},
                                              {8, {ScalarType::int32}},    {16, {ScalarType::float32}},
                                              {64, {ScalarType::float64}}, {128, {ScalarType::uint8, 3}},
                                              {256, {ScalarType::int8}},   {512, {ScalarType::uint16}},
                                              {768, {ScalarType::uint32}}, {2304, {ScalarType::uint8, 4}}};
  constexpr std::pair<int, const char*> others[] = {{32, "COMPLEX64"},    {1024, "INT64"},
                                                    {1280, "UINT64"},     {1536, "FLOAT128"},
                                                    {1792, "COMPLEX128"}, {2048, "COMPLEX256"}};
  if (const auto voxel = found(voxels, header.datatype)) return *voxel;
  const auto other = found(others, header.datatype);
  refuse(header.path, "convert them to int32, uint32 or float32 first", "{} {} cannot be rendered",
         other ? "voxels of type" : "unknown datatype", other ? *other : std::to_string(header.datatype));
}

/// NIfTI-1 standard, "scl_slope and scl_inter": a slope of 0 means that the values are as stored.
std::optional<Rescale> rescale_of(const NiftiHeader& header) {
  const double intercept = std::isfinite(header.intercept) ? header.intercept : 0;
  if (!std::isfinite(header.slope) || header.slope == 0) return {};
  if (header.slope == 1 && intercept == 0) return {};
  return Rescale{header.slope, intercept};
}

/// Of a .hdr the .img or .img.gz beside it. Some .nii say that they are one of a pair, but lie alone.
std::filesystem::path voxel_file(const NiftiHeader& header) {
  if (header.single) return header.path;
  auto base = header.path;
  if (lower_case(base.extension().string()) == ".gz") base.replace_extension();
  std::error_code ignored;
  for (const char* ending : {".img", ".IMG", ".img.gz"})
    if (auto beside = base; std::filesystem::exists(beside.replace_extension(ending), ignored)) return beside;
  const bool alone = lower_case(base.extension().string()) == ".nii" && header.offset > 0;
  return alone ? header.path : base.replace_extension(".img");
}

int vectors_of(const NiftiHeader& header) {
  std::int64_t vectors = 1;
  for (std::size_t axis = 5; axis <= 7; ++axis) {
    vectors *= header.dims[axis];
    if (vectors > std::numeric_limits<int>::max()) header.fail("its axes 5 to 7 are too long");
  }
  return int(vectors);
}

}  // namespace

std::unique_ptr<VolumeSource> open_nifti(const std::filesystem::path& path, const VolumeChoice& choice) {
  const auto header = read_nifti_header(path);
  const auto where = path.string();
  const auto voxel = voxel_of(header);
  Grid grid = nifti_grid(header);
  grid.type = voxel.type;
  auto wide = interleaved_grid(grid, voxel.colours, where);
  const int frames = int(header.dims[4]), vectors = vectors_of(header);
  if (vectors > 1 && voxel.colours > 1) refuse(where, "extract one of them", "{} colours a voxel", vectors);
  const int channels = vectors * voxel.colours;
  auto stored = stored_in(voxel_file(header));
  stored.before() = std::uint64_t(header.offset);
  stored.big_endian = header.big_endian;
  stored.type = voxel.type;
  stored.rescale = rescale_of(header);
  const auto taken =
      channels > 1 ? choose_channel(choice.channel, channels, voxel.colours > 1, where) : ChannelChoice{};
  // Volumes of time points follow each other, those of a further vector component follow all time points of
  // the one before.
  const std::int64_t vector = vectors > 1 ? taken.value_or(0) : 0;
  stored.choose(wide.bytes(), std::int64_t{frames} * vectors,
                vector * frames + chosen_frame(choice, frames, path));
  if (voxel.colours > 1) stored.rescale.reset();  // the standard: not for colours
  if (stored.rescale && grid.type != ScalarType::float64) grid.type = wide.type = ScalarType::float32;
  auto source = channel_source(stored_source(wide, {stored}), grid, voxel.colours, taken);
  return with_notes(std::move(source),
                    {.world = World::patient, .unit = "mm", .frames = frames, .channels = channels});
}

}  // namespace ringsplat::detail
