#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/channels.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/nifti/header.hpp"
#include "formats/stored_source.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

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
  for (const auto& [code, voxel] : voxels)
    if (code == header.datatype) return voxel;
  std::string name = fmt::format("unknown datatype {}", header.datatype);
  for (const auto& [code, other] : others)
    if (code == header.datatype) name = fmt::format("voxels of type {}", other);
  throw InputError(fmt::format("{}: {} cannot be rendered", header.path.string(), name),
                   "convert them to int32, uint32 or float32 first");
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

StoredVoxels stored_of(const NiftiHeader& header, ScalarType type) {
  StoredVoxels stored{.file = voxel_file(header)};
  stored.compressed = is_gzip(stored.file);
  (stored.compressed ? stored.skip : stored.offset) = std::uint64_t(header.offset);
  stored.big_endian = header.big_endian;
  stored.type = type;
  stored.rescale = rescale_of(header);
  return stored;
}

int vectors_of(const NiftiHeader& header) {
  std::int64_t vectors = 1;
  for (std::size_t axis = 5; axis <= 7; ++axis) {
    vectors *= header.dims[axis];
    if (vectors > std::numeric_limits<int>::max()) header.fail("its axes 5 to 7 are too long");
  }
  return int(vectors);
}

/// Volumes of time points follow each other, those of a further vector component follow all time points of
/// the one before.
void choose_volume(StoredVoxels& stored, const std::filesystem::path& path, std::uint64_t bytes, int frames,
                   int vectors, int frame, int vector) {
  const auto before = stored.compressed ? stored.skip : stored.offset;
  const auto total = bytes_of_volumes(path, bytes, std::uint64_t(frames) * std::uint64_t(vectors), before);
  const auto size = InputFile(stored.file).size();
  if (stored.compressed)
    require_compressed_bytes(stored.file, size, total, deflate_best_ratio);
  else
    require_bytes(stored.file, size, before, total - before);
  (stored.compressed ? stored.skip : stored.offset) +=
      (std::uint64_t(vector) * std::uint64_t(frames) + std::uint64_t(frame)) * bytes;
}

}  // namespace

std::unique_ptr<VolumeSource> open_nifti(const std::filesystem::path& path, const VolumeChoice& choice) {
  const auto header = read_nifti_header(path);
  const auto where = path.string();
  const auto voxel = voxel_of(header);
  Grid grid = nifti_grid(header);
  grid.type = voxel.type;
  check_lattice(grid, where);
  const auto wide = interleaved_grid(grid, voxel.colours, where);
  const int frames = int(header.dims[4]), vectors = vectors_of(header);
  if (vectors > 1 && voxel.colours > 1)
    throw InputError(fmt::format("{}: {} colours a voxel", where, vectors), "extract one of them");
  const int channels = vectors * voxel.colours;
  auto stored = stored_of(header, voxel.type);
  const auto taken =
      channels > 1 ? choose_channel(choice.channel, channels, voxel.colours > 1, where) : ChannelChoice{};
  choose_volume(stored, path, wide.bytes(), frames, vectors,
                std::clamp(choice.frame.value_or(0), 0, frames - 1),
                vectors > 1 ? taken.index.value_or(0) : 0);
  std::unique_ptr<VolumeSource> source;
  if (voxel.colours > 1) {
    stored.rescale.reset();  // the standard: not for colours
    source = channel_source(stored_source(wide, stored), grid, voxel.colours, taken);
  } else {
    if (stored.rescale && grid.type != ScalarType::float64) grid.type = ScalarType::float32;
    source = stored_source(grid, stored);
  }
  return with_notes(std::move(source),
                    {.world = World::patient, .unit = "mm", .frames = frames, .channels = channels});
}

}  // namespace ringsplat::detail
