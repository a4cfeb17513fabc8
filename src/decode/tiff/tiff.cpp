#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "base/log.hpp"
#include "base/text.hpp"
#include "decode/readers.hpp"
#include "decode/tiff/file.hpp"
#include "formats/axes.hpp"
#include "formats/channels.hpp"
#include "formats/limits.hpp"
#include "formats/signatures.hpp"
#include "formats/volume_files.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

/// Reads slices by number, so every process reads its own. All have the grid's size and type, which are those
/// of interleaved samples.
class TiffSource final : public LayeredSource {
 public:
  TiffSource(const Grid& grid, std::vector<TiffSlice> slices, int samples)
      : LayeredSource(grid, mapped(slices, &TiffSlice::file), {{"encoding", "TIFF"}}),
        slices_(std::move(slices)),
        samples_(samples) {}

 private:
  void read_layer(int z, int, std::span<std::byte> out) override {
    const TiffSlice& slice = slices_[std::size_t(z)];
    require_unchanged(slice.file);
    if (slice.raw_begin) {
      InputFile(slice.file).read(*slice.raw_begin, out);
      to_native_order(out, size_of(grid().type), slice.big_endian);
    } else {
      if (!image_ || opened_ != slice.file) image_ = open_tiff_image(slice.file);
      opened_ = slice.file;
      const std::string problem = image_->read(slice.page, samples_, SampleType(grid().type), out.data());
      if (!problem.empty())
        refuse(slice.file, "the file was cut short or damaged", "cannot read page {}: {}", slice.page,
               in_words(problem));
    }
    require_unchanged(slice.file);
  }

  std::vector<TiffSlice> slices_;
  int samples_;
  std::unique_ptr<ImageFile> image_;
  std::filesystem::path opened_;
};

std::vector<std::filesystem::path> files_at(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) return {path};
  std::vector<std::filesystem::path> files;
  for (const auto is_slice : {is_tiff, is_png}) {
    if (!files.empty()) break;
    for (const auto& entry : std::filesystem::directory_iterator(path))
      if (is_slice(entry.path())) files.push_back(entry.path());
  }
  std::ranges::sort(files, naturally_before, [](const auto& file) { return file.filename().string(); });
  return files;
}

struct Taken {
  std::int64_t channel = 0, frame = 0;  ///< of its planes
  ChannelChoice sample{0};              ///< of a pixel's numbers
};

Taken take(const TiffFile& file, const VolumeChoice& choice) {
  Taken taken;
  const auto where = file.path.string();
  auto of_samples = choice.channel;
  if (file.microscopy.channels > 1) {
    taken.channel =
        choose_named_channel(choice.channel, file.microscopy.channels, file.microscopy.of_channels, where);
    of_samples.clear();
  }
  const bool grey_and_alpha = file.samples == 2 && file.has_alpha && choice.channel.empty();
  constexpr int most_colours = 4;
  if (file.samples > 1 && !grey_and_alpha)
    taken.sample =
        choose_channel(of_samples, file.samples, file.samples == 3 || file.samples == most_colours, where);
  taken.frame = chosen_frame(choice, int(file.microscopy.frames), where, "time points");
  return taken;
}

void add_slices(const TiffFile& file, const Taken& taken, std::vector<TiffSlice>& slices) {
  for (std::int64_t z = 0; z < file.slices(); ++z) {
    const auto plane = file.microscopy.plane(taken.channel, z, taken.frame, file.slices());
    if (!plane || *plane >= file.planes.size())
      refuse(file.path, "write all planes into one file",
             "slice {} of channel {} at time {} is not in the file (by its {})", z, taken.channel,
             taken.frame, file.microscopy.by);
    slices.push_back(file.planes[std::size_t(*plane)]);
  }
}

/// The voxels' size, and the lattice's axes.
void place(const TiffFile& first, Grid& grid, VolumeNotes& notes) {
  grid.direction = microscope_axes;
  notes.world = World::microscope;
  const Microscopy& said = first.microscopy;
  if (!said.sized && !said.depth) return;
  constexpr double most_apart = 1000, largest = 1e12;
  const auto plausible = [&](double size) {
    return size > said.spacing.x / most_apart && size < said.spacing.x * most_apart;
  };
  const auto path = first.path.string();
  if (!(said.spacing.x > 1 / largest && said.spacing.x < largest) || !plausible(said.spacing.y)) {
    log_warning_once("{}: pixels of {:g} x {:g} {} (by its {}) are taken for 1 x 1: give --spacing", path,
                     said.spacing.x, said.spacing.y, said.unit, said.by);
    return;
  }
  grid.spacing = said.spacing;
  notes.unit = said.unit;
  if (grid.dims.z == 1 || (said.depth && plausible(said.spacing.z))) return;
  const bool image_j_one = said.by == "ImageJ" && !said.depth && plausible(said.spacing.z);
  if (!image_j_one) grid.spacing.z = grid.spacing.x;
  const auto taken = fmt::format("taken for {:g} {}", grid.spacing.z, said.unit);
  log_warning_once("{}: the distance of slices is {} (by its {}) and {}{}: give --spacing", path,
                   said.depth ? fmt::format("{:g} {}", said.spacing.z, said.unit) : "missing", said.by,
                   trimmed(taken), image_j_one ? ", as ImageJ does" : ", as of columns");
}

}  // namespace

std::unique_ptr<VolumeSource> read_tiff(const std::filesystem::path& path, const VolumeChoice& choice) {
  std::optional<TiffFile> first;
  Taken taken;
  std::vector<TiffSlice> slices;
  for (const auto& file_path : files_at(path)) {
    progress();
    const TiffFile file = read_tiff_file(file_path);
    if (!first) taken = take(file, choice);
    if (!first) first = file;
    if (file.width != first->width || file.height != first->height || file.type != first->type ||
        file.samples != first->samples || file.microscopy.channels != first->microscopy.channels ||
        file.microscopy.frames != first->microscopy.frames)
      refuse(file_path, "all slices must have one size and type",
             "it is {} x {} {} in {} channels, the files before it are {} x {} {} in {}", file.width,
             file.height, to_string(file.type), file.microscopy.channels * file.samples, first->width,
             first->height, to_string(first->type), first->microscopy.channels * first->samples);
    add_slices(file, taken, slices);
  }
  if (!first) throw InputError(fmt::format("{} has no pages", path.string()), "give a TIFF stack");
  if (slices.size() > std::size_t(std::numeric_limits<int>::max()))
    throw InputError(fmt::format("{} has {} slices", path.string(), slices.size()), "give fewer of them");
  Grid grid;
  grid.dims = {first->width, first->height, int(slices.size())};
  grid.type = first->type;
  VolumeNotes notes;
  place(*first, grid, notes);
  notes.frames = int(first->microscopy.frames);
  const int channels = int(first->microscopy.channels);
  notes.channels = channels > 1 ? channels : first->samples;
  if (channels > 1) notes.of_channels = first->microscopy.of_channels;
  std::unique_ptr<VolumeSource> source = std::make_unique<TiffSource>(
      interleaved_grid(grid, first->samples, path.string()), std::move(slices), first->samples);
  return with_notes(channel_source(std::move(source), grid, first->samples, taken.sample), notes);
}

}  // namespace ringsplat::detail
