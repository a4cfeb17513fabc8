#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "app/commands.hpp"
#include "app/render_job.hpp"
#include "base/output_file.hpp"
#include "formats/zarr/write.hpp"
#include "net/agree.hpp"
#include "program/progress.hpp"
#include "ringsplat/formats/open.hpp"
#include "ringsplat/volume/reduced.hpp"

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

/// This rank's part of a level: consecutive layers, each of which is left out if it is there. Without a
/// source nothing.
void write_part(const ZarrLevel& level, VolumeSource* source, int part, int parts, Progress& progress) {
  const auto begin_of = [&](int k) { return int(std::int64_t(level.layers()) * k / parts); };
  for (int layer = begin_of(part); source != nullptr && layer < begin_of(part + 1); ++layer) {
    if (!level.has_layer(layer)) level.write_layer(layer, *source);
    progress.at(layer + 1 - begin_of(part));
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
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const ZarrLevel level(store / std::to_string(k), levels[k]);
    // What only one process can decode in order is decoded by rank 0.
    const int parts = k > 0 || volume.concurrent ? launch.ranks() : 1;
    progress.begin(fmt::format("level {} of {}", k + 1, levels.size()), double(level.layers()) / parts);
    launch.check_on_rank_0([&] { level.begin(); });
    agree_after(launch.collectives(), [&] {
      std::unique_ptr<VolumeSource> source = std::move(volume.source), finer;
      if (k > 0) {
        finer = ringsplat::open_volume(store / std::to_string(k - 1));
        source = reduced_source(*finer, halving);
      }
      if (launch.rank() < parts) write_part(level, source.get(), launch.rank(), parts, progress);
    });
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
