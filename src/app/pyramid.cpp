#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/commands.hpp"
#include "app/render_job.hpp"
#include "base/output_file.hpp"
#include "formats/zarr/metadata.hpp"
#include "formats/zarr/write.hpp"
#include "net/agree.hpp"
#include "program/progress.hpp"
#include "ringsplat/formats/open.hpp"
#include "ringsplat/volume/reduced.hpp"
#include "volume/clipped.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::app {
namespace {

namespace fs = std::filesystem;

/// Each half as large as the one before it along each axis, the last of at most 64 voxels.
std::vector<Grid> levels_of(const Grid& finest, const Reduction& halving) {
  constexpr int coarsest = 64;
  std::vector<Grid> levels{finest};
  while (std::max({levels.back().dims.x, levels.back().dims.y, levels.back().dims.z}) > coarsest)
    levels.push_back(reduced_grid(levels.back(), halving));
  return levels;
}

/// What voxels are written.
std::string text_of(const Facts& volume, const VolumeOptions& o, const Reduction& halving) {
  std::string text =
      fmt::format("frame {}, channel {}, series {}, mask {}, halves {}\n", o.choice.frame.value_or(0),
                  o.choice.channel, o.choice.series, o.mask.path, halving.prefilter);
  for (const auto& [first, last] : o.mask.labels) text += fmt::format("labels {} to {}\n", first, last);
  for (const Fact& fact : volume) text += fmt::format("{}: {}\n", fact.field, fact.value);
  return text;
}

/// Makes the store, or goes on with one that was begun for the same voxels: while it is not complete a file
/// in it says for which. Throws InputError where something else is there.
void begin_store(const fs::path& store, const std::string& text) {
  const fs::path begun = store / ".begun";
  if (std::ifstream file(begun); file) {
    if (std::string(std::istreambuf_iterator<char>(file), {}) == text) return;
    throw InputError(fmt::format("{} was begun for another volume, or with other options", store.string()),
                     "remove it, or write to another folder");
  }
  std::error_code error;
  if (fs::exists(store) && !fs::is_empty(store, error))
    throw InputError(fmt::format("{} is there already", store.string()),
                     "remove it, or write to another folder");
  fs::create_directory(store, error);
  if (error)
    throw InputError(fmt::format("the folder {} cannot be made: {}", store.string(), error.message()),
                     "its parent folder must be there, and you may write to it");
  write_text(begun, text);
}

/// A rank's buffers for voxels; with the program itself, its libraries and a chunk's it stays below 256 MiB.
constexpr double room = 48 << 20;

/// Voxels of a block of a level, and what they are made of.
struct Block {
  std::unique_ptr<VolumeSource> finer, voxels;
};

/// Of the level before this one it reads what the filter reaches. `notes`: the volume's, which that lacks.
Block half_of(const fs::path& finer, const VoxelBox& block, const Reduction& halving,
              const VolumeNotes& notes) {
  VolumeChoice part{.memory = std::numeric_limits<double>::infinity()};
  part.crop = [&](const Grid& grid) {
    return VoxelBox{glm::max(2 * block.first - 2, 0), glm::min(2 * block.end + 2, grid.dims)};
  };
  Block half{with_notes(ringsplat::open_volume(finer, {}, part), notes), nullptr};
  const glm::ivec3 first = glm::min(block.first, 1);
  half.voxels = clipped_source(reduced_source(*half.finer, halving), VoxelBox{first, first + block.dims()});
  return half;
}

/// The blocks in which a level is written, and what reads one.
struct Plan {
  std::vector<VoxelBox> blocks;
  std::function<Block(const VoxelBox&)> open;
};

/// Of Zarr, of which a part can be read by itself, else of the source as a whole. A part of a pyramid could
/// be of another level than --memory chooses.
Plan plan_of_finest(const ZarrLevel& level, const VolumeOptions& o, OpenedVolume& volume) {
  if (std::isfinite(*o.choice.memory) || !o.mask.path.empty() || !detail::zarr::node_at(o.path))
    return {level.blocks(std::numeric_limits<double>::infinity()), [&](const VoxelBox&) {
              return Block{nullptr, std::move(volume.source)};
            }};
  const auto open = [&o](const VoxelBox& block) { return Block{nullptr, open_volume(part_of(o, block))}; };
  const auto thin = open({{0, 0, 0}, {1, 1, volume.grid.dims.z}}).voxels;
  const int interleaved = std::min(thin->notes().channels, 4);
  return {level.blocks(room / (interleaved * (level.layer_depth() + thin->layer_depth()))), open};
}

/// The source keeps a layer of the finer level and four of its slices.
Plan plan_of_half(const ZarrLevel& level, const ZarrLevel& finer, const Reduction& halving,
                  const VolumeNotes& notes) {
  return {level.blocks(room / (level.layer_depth() + 4.0 * (finer.layer_depth() + 4))),
          [&](const VoxelBox& block) { return half_of(finer.folder(), block, halving, notes); }};
}

/// This rank's part of a level: consecutive layers, block by block, each of which is left out if it is there.
void write_part(const ZarrLevel& level, const Plan& plan, int part, int parts, Progress& progress) {
  const auto count = std::int64_t(plan.blocks.size()) * level.layers(), begin = count * part / parts,
             end = count * (part + 1) / parts;
  progress.begin("writing " + level.folder().string(), double(end - begin));
  Block opened;
  for (auto k = begin; k < end; ++k) {
    const auto layer = int(k % level.layers());
    const VoxelBox& block = plan.blocks[std::size_t(k / level.layers())];
    if (k == begin || layer == 0) opened = plan.open(block);
    if (!level.has_layer(layer, block)) level.write_layer(layer, block, *opened.voxels);
    progress.at(double(k + 1 - begin));
  }
}

}  // namespace

ExitCode run(const PyramidOptions& o, Launch& launch) {
  const fs::path store(o.output);
  VolumeOptions finest = o.volume;
  if (!finest.choice.memory) finest.choice.memory = std::numeric_limits<double>::infinity();
  OpenedVolume volume = open(finest, launch);
  const Reduction halving{2, !launch.of_rank_0(o.labels || volume.notes.labels)};
  launch.check_on_rank_0([&] { begin_store(store, text_of(volume.facts, o.volume, halving)); });
  const auto levels = levels_of(volume.grid, halving);
  Progress progress(launch.rank() != 0);
  std::optional<ZarrLevel> finer;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const ZarrLevel level(store / std::to_string(k), levels[k]);
    // What only one process can decode in order is decoded by rank 0.
    const int parts = finer || volume.concurrent ? launch.ranks() : 1;
    launch.check_on_rank_0([&] { level.begin(); });
    agree_after(launch.collectives(), [&] {
      if (launch.rank() >= parts) return;
      write_part(
          level,
          finer ? plan_of_half(level, *finer, halving, volume.notes) : plan_of_finest(level, finest, volume),
          launch.rank(), parts, progress);
    });
    finer = level;
  }
  progress.end();
  launch.check_on_rank_0([&] {
    write_ome_zarr(store, levels, volume.notes);
    fs::remove(store / ".begun");
    progress.print(fmt::format("{}  {} levels, {} to {} {}", store.string(), levels.size(),
                               detail::product_of(volume.grid.dims), detail::product_of(levels.back().dims),
                               to_string(volume.grid.type)));
  });
  return ExitCode::done;
}

}  // namespace ringsplat::app
