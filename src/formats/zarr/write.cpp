#include "formats/zarr/write.hpp"

#include <blosc.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "base/output_file.hpp"
#include "formats/stored_source.hpp"
#include "formats/zarr/metadata.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

using detail::zarr::Json;
namespace fs = std::filesystem;

constexpr int clevel = 3;  ///< of 9, as blosc's zstd counts

glm::ivec3 chunk_dims(const Grid& grid) {
  constexpr std::uint64_t most = std::uint64_t{64} << 20;
  int depth = 64, side = 64;
  for (; depth > 1 && grid.slice_bytes(Axis::z) * std::uint64_t(depth) > most; depth /= 4) side *= 2;
  return {side, side, depth};
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw RunError(fmt::format("the folder {} cannot be made: {}", folder.string(), error.message()),
                   "choose a place that you may write to, on a disk with room");
}

Json slowest_first(const auto& v) { return {v.z, v.y, v.x}; }

/// By one thread, as all ranks encode.
void pack(const std::vector<std::byte>& chunk, std::size_t scalar, std::vector<std::byte>& packed) {
  constexpr int threads = 1;
  constexpr std::size_t blocks_of_its_choice = 0;
  packed.resize(chunk.size() + BLOSC_MAX_OVERHEAD);
  const int bytes = blosc_compress_ctx(clevel, BLOSC_SHUFFLE, scalar, chunk.size(), chunk.data(),
                                       packed.data(), packed.size(), "zstd", blocks_of_its_choice, threads);
  if (bytes <= 0) throw RunError(fmt::format("blosc cannot compress a chunk of {} bytes", chunk.size()));
  packed.resize(std::size_t(bytes));
}

}  // namespace

ZarrLevel::ZarrLevel(fs::path folder, const Grid& grid)
    : folder_(std::move(folder)), grid_(grid), chunk_(chunk_dims(grid)) {}

void ZarrLevel::begin() const {
  constexpr char order = std::endian::native == std::endian::big ? '>' : '<';
  make_folder(folder_);
  const Json array{
      {"zarr_format", 2},
      {"shape", slowest_first(grid_.dims)},
      {"chunks", slowest_first(chunk_)},
      {"dtype", fmt::format("{}{}", size_of(grid_.type) == 1 ? '|' : order,
                            detail::number_type(to_string(grid_.type))->code)},
      {"compressor",
       {{"id", "blosc"}, {"cname", "zstd"}, {"clevel", clevel}, {"shuffle", 1}, {"blocksize", 0}}},
      {"fill_value", 0},
      {"order", "C"},
      {"filters", nullptr},
      {"dimension_separator", "/"}};
  write_text(folder_ / ".zarray", array.dump(2));
}

std::vector<VoxelBox> ZarrLevel::blocks(double slice_bytes) const {
  glm::ivec3 step = (grid_.dims + chunk_ - 1) / chunk_;
  const auto bytes = [&] {
    const glm::dvec3 size = step * chunk_;
    return double(size_of(grid_.type)) * size.x * size.y;
  };
  while (bytes() > slice_bytes && step.x * step.y > 1) {
    int& larger = step.x > step.y ? step.x : step.y;
    larger = (larger + 1) / 2;
  }
  step *= chunk_;
  std::vector<VoxelBox> blocks;
  for (int y = 0; y < grid_.dims.y; y += step.y)
    for (int x = 0; x < grid_.dims.x; x += step.x)
      blocks.push_back({{x, y, 0}, glm::min(glm::ivec3(x, y, 0) + step, grid_.dims)});
  return blocks;
}

bool ZarrLevel::has_layer(int layer, const VoxelBox& block) const {
  for (int y = block.first.y / chunk_.y; y * chunk_.y < block.end.y; ++y)
    for (int x = block.first.x / chunk_.x; x * chunk_.x < block.end.x; ++x)
      if (!fs::exists(chunk_file(layer, y, x))) return false;
  return true;
}

std::vector<std::byte> ZarrLevel::chunk_of(std::span<const std::byte> slices, const Grid& block, int y,
                                           int x) const {
  const auto scalar = std::int64_t(size_of(grid_.type)), pitch = scalar * block.dims.x,
             slice = pitch * block.dims.y, count = std::int64_t(slices.size()) / slice;
  std::vector<std::byte> chunk(std::size_t(scalar * chunk_.x * chunk_.y * chunk_.z));
  const auto row = std::size_t(scalar * std::min(chunk_.x, block.dims.x - x));
  for (std::int64_t z = 0; z < count; ++z)
    for (int j = 0; j < std::min(chunk_.y, block.dims.y - y); ++j)
      std::memcpy(chunk.data() + (z * chunk_.y + j) * chunk_.x * scalar,
                  slices.data() + z * slice + (y + j) * pitch + x * scalar, row);
  return chunk;
}

void ZarrLevel::write_layer(int layer, const VoxelBox& block, VolumeSource& source) const {
  const int first = layer * chunk_.z, count = std::min(chunk_.z, grid_.dims.z - first);
  const Grid& grid = source.grid();
  std::vector<std::byte> slices(std::size_t(count) * grid.slice_bytes(Axis::z)), packed;
  source.read_slices(first, count, slices);
  for (int y = 0; y < grid.dims.y; y += chunk_.y) {
    const int row = (block.first.y + y) / chunk_.y;
    make_folder(chunk_file(layer, row, 0).parent_path());
    for (int x = 0; x < grid.dims.x; x += chunk_.x) {
      pack(chunk_of(slices, grid, y, x), size_of(grid_.type), packed);
      OutputFile file(chunk_file(layer, row, (block.first.x + x) / chunk_.x));
      file.write(packed);
      file.commit();
    }
  }
}

void write_ome_zarr(const fs::path& store, const std::vector<Grid>& levels, const VolumeNotes& notes) {
  const Grid& finest = levels.front();
  const std::string unit = notes.unit == "mm" ? "millimeter" : notes.unit == "um" ? "micrometer" : "";
  Json axes = Json::array(), datasets = Json::array();
  for (const char* const name : {"z", "y", "x"}) {
    axes.push_back({{"name", name}, {"type", "space"}});
    if (!unit.empty()) axes.back()["unit"] = unit;
  }
  const glm::dmat3 to_lattice = glm::inverse(finest.direction);
  for (std::size_t k = 0; k < levels.size(); ++k)
    datasets.push_back(
        {{"path", std::to_string(k)},
         {"coordinateTransformations",
          {{{"type", "scale"}, {"scale", slowest_first(levels[k].spacing)}},
           {{"type", "translation"},
            {"translation", slowest_first(to_lattice * (levels[k].origin - finest.origin))}}}}});
  const Json image{{"version", "0.4"},
                   {"name", store.stem().string()},
                   {"axes", axes},
                   {"datasets", datasets},
                   {"metadata", {{"ringsplat", detail::zarr::lattice_to_json(finest, notes)}}}};
  write_text(store / ".zgroup", Json{{"zarr_format", 2}}.dump());
  write_text(store / ".zattrs", Json{{"multiscales", Json::array({image})}}.dump(2));
}

}  // namespace ringsplat
