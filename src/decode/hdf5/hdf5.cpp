#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <span>
#include <vector>

#include "base/input_file.hpp"
#include "base/log.hpp"
#include "base/printable.hpp"
#include "base/text.hpp"
#include "decode/hdf5/axes.hpp"
#include "decode/hdf5/datasets.hpp"
#include "decode/readers.hpp"
#include "formats/channels.hpp"
#include "formats/limits.hpp"
#include "formats/signatures.hpp"
#include "formats/stored_source.hpp"
#include "formats/volume_files.hpp"
#include "ringsplat/base/error.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

using namespace hdf5;
using Role = DatasetAxis::Role;

/// What is read of a dataset. Sizes and offsets are in the order of its dimensions.
struct Selection {
  std::filesystem::path file;
  std::string dataset, where;        ///< its path in the file; both, for messages
  std::vector<hsize_t> first, size;  ///< the chosen frame and channel, and the whole of the others
  int slices = -1;                   ///< the dimension that z slices lie along; -1: there is one slice
  ValueType value = {};
  std::vector<Rescale> rescale = {};  ///< none, one for all, or one a slice
};

std::string filter_name(H5Z_filter_t id, const char* stored) {
  static const std::map<int, const char*> known{{32000, "LZF"},        {32001, "Blosc"}, {32004, "LZ4"},
                                                {32008, "Bitshuffle"}, {32013, "ZFP"},   {32015, "Zstandard"},
                                                {32026, "Blosc2"},     {307, "bzip2"},   {4, "szip"}};
  const auto found = known.find(id);
  if (found != known.end()) return found->second;
  return stored[0] == '\0' ? "unknown" : stored;
}

void require_filters(hid_t creation, const std::string& where) {
  const int filters = H5Pget_nfilters(creation);
  for (unsigned k = 0; int(k) < filters; ++k) {
    unsigned flags = 0, configuration = 0;
    std::size_t values = 0;
    char name[64] = "";
    const auto id =
        H5Pget_filter2(creation, k, &flags, &values, nullptr, sizeof(name) - 1, name, &configuration);
    if (id < 0) fail(fmt::format("{}: its filters cannot be read", where));
    if (H5Zfilter_avail(id) <= 0)
      refuse(where,
             "set HDF5_PLUGIN_PATH to a folder with its plugin, or h5repack -f GZIP=4 IN OUT where it is",
             "its chunks went through the filter {} ({}), which HDF5 does not have here",
             filter_name(id, name), int(id));
  }
}

hid_t memory_type(ScalarType type) {
  const hid_t types[] = {H5T_NATIVE_INT8,  H5T_NATIVE_UINT8,  H5T_NATIVE_INT16, H5T_NATIVE_UINT16,
                         H5T_NATIVE_INT32, H5T_NATIVE_UINT32, H5T_NATIVE_FLOAT, H5T_NATIVE_DOUBLE};
  return types[std::size_t(type)];
}

Facts facts_of(const Selection& selection) {
  std::string first;
  for (const hsize_t at : selection.first) first += fmt::format("{}{}", first.empty() ? "" : " ", at);
  Facts facts{{"encoding", "HDF5"},
              {"dataset", selection.dataset},
              {"stored type", selection.value.name},
              {"first voxel", first}};
  if (!selection.rescale.empty())
    facts.push_back({"rescale", fmt::format("{:.17g} {:.17g}", selection.rescale.front().slope,
                                            selection.rescale.front().intercept)});
  return facts;
}

/// The voxels of the selection. Its layers are the chunks' layers.
class DatasetSource final : public LayeredSource {
 public:
  DatasetSource(const Grid& grid, Id dataset, Selection selection)
      : LayeredSource(grid, {selection.file}, facts_of(selection)),
        dataset_(std::move(dataset)),
        selection_(std::move(selection)) {
    const Id creation = made(H5Dget_create_plist(dataset_.get()), selection_.where);
    std::vector<hsize_t> chunk(selection_.first.size());
    const int rank = int(chunk.size());
    if (selection_.slices >= 0 && H5Pget_layout(creation.get()) == H5D_CHUNKED &&
        H5Pget_chunk(creation.get(), rank, chunk.data()) == rank)
      set_layer(chunk[std::size_t(selection_.slices)]);
  }

 private:
  void read_layer(int begin, int end, std::span<std::byte> out) override {
    require_unchanged(selection_.file);
    if (!selection_.rescale.empty()) {
      std::vector<double> values(out.size() / size_of(grid().type));
      read_as(H5T_NATIVE_DOUBLE, begin, end, values.data());
      const auto in = std::as_bytes(std::span(values));
      for (int z = begin; z < end; ++z) {
        const auto at = std::size_t(z - begin), count = std::size_t(end - begin);
        const auto& rescale = selection_.rescale[selection_.rescale.size() > 1 ? std::size_t(z) : 0];
        apply(rescale, ScalarType::float64, in.subspan(in.size() / count * at, in.size() / count),
              grid().type, out.subspan(out.size() / count * at, out.size() / count));
      }
    } else if (selection_.value.wide) {
      read_wide(begin, end, out);
    } else {
      read_as(memory_type(grid().type), begin, end, out.data());
    }
    require_unchanged(selection_.file);
  }

  /// 64-bit integers as float64, in place.
  void read_wide(int begin, int end, std::span<std::byte> out) {
    const bool is_signed = selection_.value.name.find("uint") == std::string::npos;
    read_as(is_signed ? H5T_NATIVE_INT64 : H5T_NATIVE_UINT64, begin, end, out.data());
    constexpr std::uint64_t largest = std::uint64_t{1} << 53;
    for (std::size_t at = 0; at < out.size(); at += sizeof(double)) {
      std::uint64_t bits;
      std::memcpy(&bits, out.data() + at, sizeof(bits));
      const bool negative = is_signed && bits >> 63 != 0;
      const std::uint64_t magnitude = negative ? ~bits + 1 : bits;
      if (magnitude > largest)
        refuse(selection_.where, "convert the dataset to 32-bit integers or floats first",
               "the 64-bit integer {}{} has no exact float64", negative ? "-" : "", magnitude);
      const double value = negative ? -double(magnitude) : double(magnitude);
      std::memcpy(out.data() + at, &value, sizeof(value));
    }
  }

  void read_as(hid_t type, int begin, int end, void* out) {
    auto first = selection_.first, size = selection_.size;
    if (selection_.slices >= 0) {
      first[std::size_t(selection_.slices)] = hsize_t(begin);
      size[std::size_t(selection_.slices)] = hsize_t(end - begin);
    }
    const Id stored = made(H5Dget_space(dataset_.get()), selection_.where);
    done(H5Sselect_hyperslab(stored.get(), H5S_SELECT_SET, first.data(), nullptr, size.data(), nullptr),
         selection_.where);
    const Id memory = made(H5Screate_simple(int(size.size()), size.data(), nullptr), selection_.where);
    if (H5Dread(dataset_.get(), type, memory.get(), stored.get(), H5P_DEFAULT, out) < 0)
      fail(fmt::format("{}: slices {} to {} cannot be read", selection_.where, begin, end - 1));
  }

  Id dataset_;
  Selection selection_;
};

/// Throws InputError, naming the reason, for voxels that the file does not hold itself or that need a filter
/// which is missing, and for sizes that the file cannot hold.
void require_readable(hid_t dataset, const std::filesystem::path& file, const std::string& where) {
  const Id creation = made(H5Dget_create_plist(dataset), where);
  const H5D_layout_t layout = H5Pget_layout(creation.get());
  if (layout == H5D_VIRTUAL)
    refuse(where, "h5repack IN OUT writes them into one file",
           "a virtual dataset, whose voxels other datasets hold");
  if (layout < 0) fail(fmt::format("{}: its layout cannot be read", where));
  if (H5Pget_external_count(creation.get()) != 0)
    refuse(where, "h5repack IN OUT writes them into one file", "its voxels lie in other files");
  require_filters(creation.get(), where);
  const auto dims = dims_of(dataset);
  const Id type = made(H5Dget_type(dataset), where);
  std::uint64_t bytes = H5Tget_size(type.get());
  for (const int size : dims) {
    if (bytes > (std::uint64_t{1} << 62) / std::uint64_t(size))
      refuse(where, "write it again", "its dimensions are too large for any file");
    bytes *= std::uint64_t(size);
  }
  const InputFile on_disk(file);
  const std::uint64_t stored = H5Dget_storage_size(dataset);
  if (stored == 0) refuse(where, "write them, or name another dataset", "its voxels were never written");
  if (layout == H5D_CONTIGUOUS) {
    const haddr_t at = H5Dget_offset(dataset);
    if (at == HADDR_UNDEF) fail(fmt::format("{}: its voxels' place cannot be read", where));
    require_bytes(file, on_disk.size(), at, bytes);
  }
  if (layout == H5D_CHUNKED) require_compressed_bytes(file, on_disk.size(), bytes, any_best_ratio);
}

/// Where the file holds the voxels of the selection, in the order in which they are read and as they are;
/// nothing where it does not. `dims`: the dataset's.
std::optional<StoredVoxels> stored_in_place(hid_t dataset, const Selection& selection,
                                            const std::vector<int>& dims) {
  const Id creation(H5Dget_create_plist(dataset)), stored(H5Dget_type(dataset));
  const haddr_t offset = H5Dget_offset(dataset);
  if (!selection.rescale.empty() || selection.value.wide || !stored || offset == HADDR_UNDEF ||
      H5Pget_layout(creation.get()) != H5D_CONTIGUOUS)
    return {};
  const Id base(H5Tget_class(stored.get()) == H5T_ENUM ? H5Tget_super(stored.get()) : H5Tcopy(stored.get())),
      little(H5Tcopy(memory_type(selection.value.type))), big(H5Tcopy(little.get()));
  H5Tset_order(little.get(), H5T_ORDER_LE);
  H5Tset_order(big.get(), H5T_ORDER_BE);
  const bool is_big = H5Tequal(base.get(), big.get()) > 0;
  if (!is_big && H5Tequal(base.get(), little.get()) <= 0) return {};
  // In front of the first dimension of which more than one voxel is taken any may be left out, behind it
  // none.
  std::uint64_t first = 0;
  bool whole = false;
  for (std::size_t k = 0; k < dims.size(); ++k) {
    if (whole && selection.size[k] != hsize_t(dims[k])) return {};
    whole |= selection.size[k] > 1;
    first = first * std::uint64_t(dims[k]) + selection.first[k];
  }
  StoredVoxels found;
  found.file = selection.file;
  found.offset = std::uint64_t(offset) + first * size_of(selection.value.type);
  found.big_endian = is_big;
  found.type = selection.value.type;
  return found;
}

void require_hdf5(const std::filesystem::path& path) {
  if (is_hdf5(path)) return;
  const InputFile file(path);
  if (begins_with(file, 0, "CDF")) {
    const bool minc = lower_case(path.extension().string()) == ".mnc";
    refuse(path, minc ? "convert it: mincconvert -2 IN OUT" : "convert it: nccopy -k nc4 IN OUT",
           "{}classic netCDF, which is not HDF5", minc ? "MINC 1, " : "");
  }
  if (begins_with(file, 0, "\x0e\x03\x13\x01"))
    refuse(path, "convert it: h4toh5 IN OUT", "HDF4, which is not HDF5");
  throw InputError(fmt::format("{} is no HDF5 file", path.string()),
                   "the file is damaged or has a wrong ending");
}

struct Channels {
  int dimension = -1;  ///< -1: none
  int count = 1;
  ChannelChoice choice = {0};
};

Channels channels_of(const std::vector<DatasetAxis>& axes, const ValueType& value, const VolumeChoice& choice,
                     const std::string& where) {
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

/// Of frames and channels one, but all of colours whose luminance is made.
void select(const std::vector<DatasetAxis>& axes, const Channels& channels, int frame, Selection& selection) {
  for (std::size_t k = 0; k < axes.size(); ++k) {
    const bool is_channel = axes[k].role == Role::channel;
    const bool whole = axes[k].role == Role::space || (is_channel && !channels.choice.index);
    const int other = is_channel ? channels.choice.index.value_or(0) : 0;
    selection.first.push_back(hsize_t(axes[k].role == Role::frame ? frame : other));
    selection.size.push_back(whole ? hsize_t(axes[k].size) : 1);
  }
  selection.slices = lattice_axes(axes)[2];
}

}  // namespace

std::unique_ptr<VolumeSource> read_hdf5(const std::filesystem::path& path, const VolumeChoice& choice,
                                        std::optional<StoredVoxels>& in_place) {
  const auto [path_of_file, named] = split_dataset(path);
  require_hdf5(path_of_file);
  const Id file = open_file(path_of_file);
  Iterations iterations;
  Selection selection;
  selection.file = path_of_file;
  selection.dataset = choose_dataset(file.get(), path_of_file, named, choice, iterations);
  selection.where = path_of_file.string() + ":" + ringsplat::excerpt(selection.dataset, 200);
  const auto& where = selection.where;
  Id dataset = open_object(file.get(), selection.dataset, where);
  const auto dims = dims_of(dataset.get());
  const Id type = made(H5Dget_type(dataset.get()), where);
  const auto value = value_type_of(type.get());
  if (!value)
    refuse(where, "only integers and floating-point numbers can be drawn",
           "its values are no single numbers of at most 64 bits");
  if (dims.size() < 2) refuse(where, "name another dataset", "it has no three dimensions with voxels");
  require_readable(dataset.get(), path_of_file, where);
  auto meaning = meaning_of(file.get(), dataset.get(), selection.dataset, dims, where);
  auto& notes = meaning.notes;
  const Channels channels = channels_of(meaning.axes, *value, choice, where);
  const bool by_iteration = iterations.count > 1;
  const int frame = by_iteration ? 0 : chosen_frame(choice, notes.frames, "volumes", where);
  if (by_iteration) notes.frames = iterations.count;
  select(meaning.axes, channels, frame, selection);
  selection.value = *value;
  Grid grid = lattice_of(meaning, where);
  auto& rescale = selection.rescale = std::move(meaning.rescale);
  if (rescale.size() > 1) {  // of all frames
    const auto first = rescale.begin() + std::ptrdiff_t(frame) * grid.dims.z;
    rescale = std::vector(first, first + grid.dims.z);
  }
  grid.type = rescale.empty() || value->type == ScalarType::float64 ? value->type : ScalarType::float32;
  notes.labels = value->labels;
  if (notes.fill && rescale.size() == 1) {
    const double fill = rescale[0].slope * *notes.fill + rescale[0].intercept;
    notes.fill = grid.type == ScalarType::float32 ? double(float(fill)) : fill;
  }
  const int components = channels.choice.index ? 1 : channels.count;
  if (components == 1) in_place = stored_in_place(dataset.get(), selection, dims);
  auto source = std::make_unique<DatasetSource>(interleaved_grid(grid, components, where), std::move(dataset),
                                                std::move(selection));
  return with_notes(channel_source(std::move(source), grid, components, channels.choice), notes);
}

}  // namespace ringsplat::detail
