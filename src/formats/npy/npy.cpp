#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/npy/header.hpp"
#include "formats/stored_source.hpp"
#include "formats/transposed_source.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

/// Which of the array's axes are what: [frame][z][y][x][component]; missing ones have 1.
struct Axes {
  int frames = 1, components = 1;
  glm::ivec3 dims{1};
};

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what, const std::string& hint) {
  throw InputError(fmt::format("{}: {}", path.string(), what), hint);
}

std::string text_of(const std::vector<std::int64_t>& shape) {
  std::vector<std::string> sizes;
  for (const auto size : shape) sizes.push_back(fmt::format("{}", size));
  return fmt::format("({})", comma_list(sizes));
}

/// Of four or five axes the last one is of components when it is as short as a colour's.
Axes axes_of(const NpyHeader& header, const std::filesystem::path& path) {
  constexpr const char* order = "axes are [z][y][x], [frame][z][y][x] or [z][y][x][1 to 4 components]";
  constexpr std::int64_t most_components = 4;
  std::vector<int> sizes;
  for (const auto size : header.shape) {
    if (size < 1 || size > std::numeric_limits<int>::max())
      fail(path, fmt::format("its array has the shape {}", text_of(header.shape)),
           "every axis must have a size from 1 to 2^31 - 1");
    sizes.push_back(int(size));
  }
  if (sizes.size() < 2 || sizes.size() > 5)
    fail(path, fmt::format("its array has the shape {}", text_of(header.shape)), order);
  Axes axes;
  if (sizes.size() > 3 && sizes.back() <= most_components) {
    axes.components = sizes.back();
    sizes.pop_back();
  }
  if (sizes.size() > 4) fail(path, fmt::format("its array has the shape {}", text_of(header.shape)), order);
  if (sizes.size() == 4) {
    axes.frames = sizes.front();
    sizes.erase(sizes.begin());
  }
  for (int axis = 0; axis < int(sizes.size()); ++axis)
    axes.dims[axis] = sizes[sizes.size() - 1 - std::size_t(axis)];
  return axes;
}

/// IEEE 754 binary16 as binary32, which holds every one of its values.
float float_of_half(std::uint16_t half) {
  const auto sign = std::uint32_t(half & 0x8000U) << 16;
  const std::uint32_t exponent = (half >> 10) & 31U, fraction = half & 0x3FFU;
  constexpr float smallest = 1.0F / (1 << 24);
  if (exponent == 0) return (sign != 0 ? -smallest : smallest) * float(fraction);
  const std::uint32_t wide = exponent == 31 ? 255 : exponent + 127 - 15;
  return std::bit_cast<float>(sign | wide << 23 | fraction << 13);
}

/// Widens a source of binary16 numbers that its grid calls uint16.
class HalfSource final : public ForwardingSource {
 public:
  explicit HalfSource(std::unique_ptr<VolumeSource> halves)
      : ForwardingSource(std::move(halves)), grid_(ForwardingSource::grid()) {
    grid_.type = ScalarType::float32;
  }
  const Grid& grid() const override { return grid_; }
  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto values = grid_.slice_voxels(Axis::z) * std::size_t(count);
    std::vector<std::uint16_t> halves(values);
    ForwardingSource::read_slices(first, count, std::as_writable_bytes(std::span(halves)));
    std::transform(halves.begin(), halves.end(), reinterpret_cast<float*>(out.data()), float_of_half);
  }

 private:
  Grid grid_;
};

}  // namespace

std::unique_ptr<VolumeSource> open_npy(const std::filesystem::path& path, const VolumeChoice& choice) {
  const auto header = read_npy_header(path);
  const auto axes = axes_of(header, path);
  if (header.fortran_order && header.shape.size() > 3)
    fail(path, fmt::format("its array of shape {} is in Fortran order", text_of(header.shape)),
         "save np.ascontiguousarray(a), whose axes are [frame][z][y][x] or [z][y][x][component]");
  Grid grid;
  grid.dims = axes.dims;
  grid.type = header.type;
  check_lattice(grid, path.string());
  const auto wide = interleaved_grid(grid, axes.components, path.string());
  const auto size = InputFile(path).size();
  const auto frame = std::uint64_t(std::clamp(choice.frame.value_or(0), 0, axes.frames - 1));
  require_bytes(path, size, header.end, bytes_of_volumes(path, wide.bytes(), std::uint64_t(axes.frames)));
  auto source = header.fortran_order ? transposed_source(wide, path, header.end, header.big_endian)
                                     : stored_source(wide, {.file = path,
                                                            .offset = header.end + frame * wide.bytes(),
                                                            .big_endian = header.big_endian,
                                                            .type = header.type});
  if (header.half) {
    source = std::make_unique<HalfSource>(std::move(source));
    grid.type = ScalarType::float32;
  }
  if (axes.components > 1) {
    const auto taken = choose_channel(choice.channel, axes.components,
                                      !header.half && are_colours(grid.type, axes.components), path.string());
    source = channel_source(std::move(source), grid, axes.components, taken);
  }
  return with_notes(std::move(source), {.frames = axes.frames, .channels = axes.components});
}

std::unique_ptr<VolumeSource> refuse_npz(const std::filesystem::path& path, const VolumeChoice&) {
  fail(path, "a .npz is an archive of arrays",
       "save one of them by itself: np.save('volume.npy', np.load('volume.npz')['NAME'])");
}

}  // namespace ringsplat::detail
