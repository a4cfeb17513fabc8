#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "base/input_file.hpp"
#include "base/log.hpp"
#include "base/printable.hpp"
#include "base/text.hpp"
#include "decode/hdf5/axes.hpp"
#include "decode/hdf5/datasets.hpp"
#include "decode/hdf5/source.hpp"
#include "decode/readers.hpp"
#include "formats/channels.hpp"
#include "formats/signatures.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail {
namespace {

using hdf5::DatasetAxis;
using Role = DatasetAxis::Role;

void require_hdf5(const std::filesystem::path& path) {
  if (is_hdf5(path)) return;
  const InputFile file(path);
  if (begins_with(file, 0, "CDF")) {
    const bool minc = lower_case(path.extension().string()) == ".mnc";
    throw InputError(
        fmt::format("{}: {}classic netCDF, which is not HDF5", path.string(), minc ? "MINC 1, " : ""),
        minc ? "convert it: mincconvert -2 IN OUT" : "convert it: nccopy -k nc4 IN OUT");
  }
  if (begins_with(file, 0, "\x0e\x03\x13\x01"))
    throw InputError(fmt::format("{}: HDF4, which is not HDF5", path.string()), "convert it: h4toh5 IN OUT");
  throw InputError(fmt::format("{} is no HDF5 file", path.string()),
                   "the file is damaged or has a wrong ending");
}

/// The number that --frame chooses; require_choice_there() has the message of a wrong one.
int frame_of(const VolumeChoice& choice, int frames, const std::string& where) {
  const int frame = choice.frame.value_or(0);
  if (frame < 0 || frame >= frames)
    throw InputError(fmt::format("--frame {}: {} holds {} volumes", frame, where, frames),
                     fmt::format("frames are numbered from 0 to {}", frames - 1));
  return frame;
}

struct Channels {
  int dimension = -1;  ///< -1: none
  int count = 1;
  ChannelChoice choice = {0};
};

Channels channels_of(const std::vector<DatasetAxis>& axes, const hdf5::ValueType& value,
                     const VolumeChoice& choice, const std::string& where) {
  Channels channels;
  for (std::size_t k = 0; k < axes.size(); ++k)
    if (axes[k].role == Role::channel) channels = {int(k), axes[k].size, {0}};
  if (channels.dimension < 0) return channels;
  const bool last = channels.dimension + 1 == int(axes.size());
  if (!last && choice.channel.empty()) {
    log_warning_once("{}: it has {} channels, the first is shown; --channel N shows another", where,
                     channels.count);
    return channels;
  }
  channels.choice =
      choose_channel(choice.channel, channels.count, last && are_colours(value.type, channels.count), where);
  return channels;
}

ScalarType rescaled_type(const hdf5::ValueType& value) {
  return value.type == ScalarType::float64 ? ScalarType::float64 : ScalarType::float32;
}

/// What is read: of frames and channels one, but all of colours whose luminance is made.
hdf5::Selection select(const std::filesystem::path& file, const std::string& dataset,
                       const std::vector<DatasetAxis>& axes, const Channels& channels, int frame) {
  hdf5::Selection selection;
  selection.file = file;
  selection.dataset = dataset;
  for (std::size_t k = 0; k < axes.size(); ++k) {
    const bool whole =
        axes[k].role == Role::space || (axes[k].role == Role::channel && !channels.choice.index);
    const int at = axes[k].role == Role::frame     ? frame
                   : axes[k].role == Role::channel ? channels.choice.index.value_or(0)
                                                   : 0;
    selection.first.push_back(hsize_t(at));
    selection.size.push_back(whole ? hsize_t(axes[k].size) : 1);
  }
  selection.slices = hdf5::lattice_axes(axes)[2];
  return selection;
}

/// A dataset that can be read, with everything closed again: who opens it next says how it is cached.
struct Described {
  Grid grid;
  VolumeNotes notes;
  hdf5::Selection selection;
  Channels channels;
  std::string where;
  std::optional<StoredVoxels> in_place = {};
};

Described describe(const std::filesystem::path& path, const std::string& named, const VolumeChoice& choice) {
  const hdf5::Quiet quiet;
  const hdf5::Id file = hdf5::open_file(path);
  hdf5::Iterations iterations;
  const std::string dataset = hdf5::choose_dataset(file.get(), path, named, choice, iterations);
  const std::string where = path.string() + ":" + ringsplat::excerpt(dataset, 200);
  const hdf5::Id id = hdf5::open_object(file.get(), dataset, where);
  const auto dims = hdf5::dims_of(id.get());
  const hdf5::Id type = hdf5::made(H5Dget_type(id.get()), where);
  const auto value = hdf5::value_type_of(type.get());
  if (!value)
    throw InputError(fmt::format("{}: its values are no single numbers of at most 64 bits", where),
                     "only integers and floating-point numbers can be drawn");
  if (dims.size() < 2)
    throw InputError(fmt::format("{}: it has no three dimensions with voxels", where),
                     "name another dataset");
  hdf5::require_readable(id.get(), path, where);
  auto meaning = hdf5::meaning_of(file.get(), id.get(), dataset, dims, where);
  const Channels channels = channels_of(meaning.axes, *value, choice, where);
  const bool by_iteration = iterations.count > 1;
  const int frame = by_iteration ? 0 : frame_of(choice, meaning.notes.frames, where);
  if (by_iteration) meaning.notes.frames = iterations.count;
  auto selection = select(path, dataset, meaning.axes, channels, frame);
  selection.value = *value;
  Grid grid = hdf5::lattice_of(meaning, where);
  auto& rescale = selection.rescale = std::move(meaning.rescale);
  if (rescale.size() > 1) {  // of all frames
    const auto first = rescale.begin() + std::ptrdiff_t(frame) * grid.dims.z;
    rescale = std::vector(first, first + grid.dims.z);
  }
  grid.type = rescale.empty() ? value->type : rescaled_type(*value);
  meaning.notes.labels = value->labels;
  if (meaning.notes.fill && rescale.size() == 1) {
    const double fill = rescale[0].slope * *meaning.notes.fill + rescale[0].intercept;
    meaning.notes.fill = grid.type == ScalarType::float32 ? double(float(fill)) : fill;
  }
  auto in_place = channels.choice.index ? hdf5::stored_in_place(id.get(), selection, dims) : std::nullopt;
  return {grid, meaning.notes, std::move(selection), channels, where, std::move(in_place)};
}

std::unique_ptr<VolumeSource> source_of(Described found) {
  if (found.channels.choice.index)
    return hdf5::dataset_source(found.grid, found.notes, std::move(found.selection));
  const Grid interleaved = interleaved_grid(found.grid, found.channels.count, found.where);
  return channel_source(hdf5::dataset_source(interleaved, found.notes, std::move(found.selection)),
                        found.grid, found.channels.count, found.channels.choice);
}

}  // namespace

std::unique_ptr<VolumeSource> read_hdf5(const std::filesystem::path& path, const VolumeChoice& choice,
                                        std::optional<StoredVoxels>& in_place) {
  const auto [file, named] = split_dataset(path);
  require_hdf5(file);
  auto found = describe(file, named, choice);
  in_place = found.in_place;
  return source_of(std::move(found));
}

}  // namespace ringsplat::detail
