#include <filesystem>

#include "app/commands.hpp"
#include "base/output_file.hpp"
#include "base/text.hpp"
#include "formats/limits.hpp"
#include "formats/write.hpp"
#include "program/progress.hpp"
#include "program/text_output.hpp"
#include "volume/synth.hpp"

namespace ringsplat::app {
namespace {

namespace fs = std::filesystem;

/// Checks the disk's space before the work: RunError when too little is free, InputError when the whole disk
/// is too small.
void check_room(const fs::path& file, const Grid& grid, bool compressed) {
  const std::uint64_t needed = grid.bytes() / (compressed ? detail::deflate_best_ratio : 1);
  std::error_code error;
  const auto space = fs::space(file.has_parent_path() ? file.parent_path() : ".", error);
  if (error || needed <= space.available) return;
  const std::string problem =
      fmt::format("{} cannot be written: {} {} needs {} KiB, but the disk has {} KiB left", file.string(),
                  detail::product_of(grid.dims), to_string(grid.type), needed >> 10, space.available >> 10);
  const bool full = space.available < space.capacity / 100;
  if (needed > space.capacity && !full) throw InputError(problem, "use smaller --dims");
  throw RunError(problem, "make room, or use smaller --dims");
}

}  // namespace

ExitCode run(const SynthOptions& o) {
  if (o.list) {
    std::string text;
    for (const auto& synth : synth_names()) text += fmt::format("{:<20}{}\n", synth.name, synth.description);
    write_text_output("-", text);
    return ExitCode::done;
  }
  if (o.name.empty())
    throw InputError("the NAME of the volume to make is missing",
                     "ringsplat synth --list says what there is");
  if (o.output.empty())
    throw InputError("-o FILE is missing",
                     fmt::format("for instance ringsplat synth {} -o {}.nrrd", o.name, o.name));
  Grid grid;
  grid.dims = o.dims;
  grid.type = o.type;
  grid.spacing = o.spacing;
  auto source = synth_source(o.name, grid);
  check_can_write(o.output, "-o");
  check_room(o.output, grid, !o.no_compression && fs::path(o.output).extension() == ".nrrd");
  Progress progress;
  progress.begin("writing " + o.output, grid.dims.z);
  WatchedSource watched(std::move(source), [&](int slices) { progress.at(slices); });
  const auto written = write_volume(watched, o.output, !o.no_compression);
  progress.end();
  progress.print(
      fmt::format("{}  {} {}", written.string(), detail::product_of(grid.dims), to_string(grid.type)));
  return ExitCode::done;
}

}  // namespace ringsplat::app
