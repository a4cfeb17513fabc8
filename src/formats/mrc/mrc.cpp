#include <cmath>
#include <glm/trigonometric.hpp>
#include <utility>

#include "base/byte_order.hpp"
#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

constexpr const char* hint = "write it with mrcfile, or as .nrrd";

/// MRC2014: words of four bytes, numbered from 1.
struct MrcHeader {
  std::vector<std::byte> bytes = std::vector<std::byte>(1024);
  bool big_endian = false;

  template <class T = int>
  T word(std::size_t number) const {
    return BinaryFields(bytes, big_endian).at<T>(4 * (number - 1));
  }
  glm::ivec3 counts(std::size_t first) const { return {word(first), word(first + 1), word(first + 2)}; }
  glm::dvec3 reals(std::size_t first) const {
    return {word<float>(first), word<float>(first + 1), word<float>(first + 2)};
  }
};

ScalarType stored_type(const MrcHeader& header, const std::filesystem::path& path) {
  constexpr std::pair<int, ScalarType> types[] = {{0, ScalarType::int8},
                                                  {1, ScalarType::int16},
                                                  {2, ScalarType::float32},
                                                  {6, ScalarType::uint16},
                                                  {12, ScalarType::uint16}};
  const int mode = header.word(4);
  constexpr int imod = 1146047817, is_signed = 1;  // IMOD says whether its bytes are
  if (mode == 0 && header.word(39) == imod && (header.word(40) & is_signed) == 0) return ScalarType::uint8;
  if (const auto type = found(types, mode)) return *type;
  refuse(path, hint, "voxels of mode {} cannot be rendered", mode);
}

/// The cell's axes in the world: the first along x, the second in the plane of x and y.
glm::dmat3 cell_axes(const MrcHeader& header) {
  const auto angles = header.reals(14);
  if (angles == glm::dvec3(90) || angles == glm::dvec3(0)) return glm::dmat3(1);
  const auto cosines = glm::cos(glm::radians(angles));
  const double sine = std::sin(glm::radians(angles.z)), y = (cosines.x - cosines.y * cosines.z) / sine;
  return {glm::dvec3(1, 0, 0), glm::dvec3(cosines.z, sine, 0),
          glm::dvec3(cosines.y, y, std::sqrt(1 - cosines.y * cosines.y - y * y))};
}

/// Columns, rows and sections lie along any of the cell's axes.
Grid grid_of(const MrcHeader& header, const std::filesystem::path& path) {
  const auto start = header.counts(5), samples = header.counts(8), along = header.counts(17);
  const auto cell = header.reals(11), origin = header.reals(50);
  const auto axes = cell_axes(header);
  Grid grid;
  grid.dims = header.counts(1);
  for (int k = 0; k < 3; ++k) {
    const int axis = along == glm::ivec3(0) ? k : along[k] - 1;
    if (axis < 0 || axis > 2) refuse(path, hint, "its axes are {} {} {}", along.x, along.y, along.z);
    if (samples[axis] > 0 && cell[axis] > 0) grid.spacing[k] = cell[axis] / samples[axis];
    grid.direction[k] = axes[axis];
    grid.origin += start[k] * grid.spacing[k] * axes[axis];
  }
  if (origin != glm::dvec3(0)) grid.origin = origin;
  return grid;
}

}  // namespace

std::unique_ptr<VolumeSource> open_mrc(const std::filesystem::path& path, const VolumeChoice& choice) {
  MrcHeader header;
  auto stored = stored_in(path);
  stored.read_head(header.bytes);
  // Some writers leave the stamp of the byte order out; columns are fewer than 2^16.
  header.big_endian = BinaryFields(header.bytes, true).at<unsigned>(0) < header.word<unsigned>(1);
  Grid grid = grid_of(header, path);
  grid.type = stored_type(header, path);
  // Of a stack of volumes the cell has the sections of one.
  constexpr int first_stack = 401, half = 12;
  const int sections = header.word(10), extended = header.word(24);
  const bool stack = header.word(23) >= first_stack && sections > 0 && grid.dims.z % sections == 0;
  const int frames = stack ? grid.dims.z / sections : 1;
  if (stack) grid.dims.z = sections;
  check_lattice(grid, path.string());
  if (extended < 0) refuse(path, hint, "its extended header has {} bytes", extended);
  stored.before() = header.bytes.size() + std::uint64_t(extended);
  stored.big_endian = header.big_endian;
  stored.type = grid.type;
  stored.choose(grid.bytes(), frames, chosen_frame(choice, frames, path));
  stored.half = header.word(4) == half;
  if (stored.half) grid.type = ScalarType::float32;
  const bool sized = header.reals(11) != glm::dvec3(0);
  return with_notes(stored_source(grid, {stored}), {.unit = sized ? "angstrom" : "", .frames = frames});
}

}  // namespace ringsplat::detail
