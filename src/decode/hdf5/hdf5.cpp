#include <span>
#include <utility>
#include <vector>

#include "base/input_file.hpp"
#include "base/printable.hpp"
#include "base/text.hpp"
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

struct Selection {
  std::filesystem::path file;
  std::string dataset, where;  ///< its path in the file; both, for messages
  ArrayPart part;
  ValueType value = {};
  std::vector<Rescale> rescale = {};  ///< none, one for all, or one a slice
};

std::string filter_name(H5Z_filter_t id, const char* stored) {
  constexpr std::pair<int, const char*> known[] = {
      {32000, "LZF"},        {32001, "Blosc"}, {32004, "LZ4"},
      {32008, "Bitshuffle"}, {32013, "ZFP"},   {32015, "Zstandard"},
      {32026, "Blosc2"},     {307, "bzip2"},   {4, "szip"}};
  if (const auto name = found(known, id)) return *name;
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
  Facts facts{{"encoding", "HDF5"},
              {"dataset", selection.dataset},
              {"stored type", selection.value.name},
              {"first voxel", joined(selection.part.first, " ")}};
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
    std::vector<hsize_t> chunk(selection_.part.first.size());
    const int rank = int(chunk.size()), slices = selection_.part.lattice[2];
    if (slices >= 0 && H5Pget_layout(creation.get()) == H5D_CHUNKED &&
        H5Pget_chunk(creation.get(), rank, chunk.data()) == rank)
      set_layer(chunk[std::size_t(slices)]);
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
      // 64-bit integers as float64, in place.
      const bool is_signed = selection_.value.name.find("uint") == std::string::npos;
      read_as(is_signed ? H5T_NATIVE_INT64 : H5T_NATIVE_UINT64, begin, end, out.data());
      doubles_of_integers(out, is_signed, selection_.where);
    } else {
      read_as(memory_type(grid().type), begin, end, out.data());
    }
    require_unchanged(selection_.file);
  }

  void read_as(hid_t type, int begin, int end, void* out) {
    const auto& part = selection_.part;
    std::vector<hsize_t> first(part.first.begin(), part.first.end()), size;
    for (std::size_t k = 0; k < first.size(); ++k) size.push_back(hsize_t(part.end[k] - part.first[k]));
    if (const int slices = part.lattice[2]; slices >= 0) {
      first[std::size_t(slices)] = hsize_t(begin);
      size[std::size_t(slices)] = hsize_t(end - begin);
    }
    const Id stored = made(H5Dget_space(dataset_.get()), selection_.where);
    if (H5Sselect_hyperslab(stored.get(), H5S_SELECT_SET, first.data(), nullptr, size.data(), nullptr) < 0)
      fail(selection_.where);
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
    const auto size = selection.part.end[k] - selection.part.first[k];
    if (whole && size != dims[k]) return {};
    whole |= size > 1;
    first = first * std::uint64_t(dims[k]) + std::uint64_t(selection.part.first[k]);
  }
  return StoredVoxels{.file = selection.file,
                      .offset = std::uint64_t(offset) + first * size_of(selection.value.type),
                      .big_endian = is_big,
                      .type = selection.value.type};
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

/// By the conventions; else as settle_roles() has it. Warns of what is drawn otherwise than it is. Throws
/// InputError for meshes that are not rectilinear and sizes that contradict each other.
DatasetMeaning meaning_of(hid_t file, hid_t dataset, const std::string& path, const std::vector<int>& dims,
                          const std::string& where) {
  DatasetMeaning meaning;
  for (const int size : dims) meaning.axes.push_back({.size = size});
  describe_microscopy(dataset, meaning);
  describe_netcdf(dataset, where, meaning);
  describe_openpmd(file, dataset, path, where, meaning);
  describe_vtkhdf(file, path, where, meaning);
  describe_minc(file, dataset, path, where, meaning);
  settle_roles(meaning, where, "name them by the attribute DIMENSION_LABELS, or write one volume a dataset");
  return meaning;
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
  selection.where = path_of_file.string() + ":" + excerpt(selection.dataset, 200);
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
  VolumeChoice within = choice;
  if (iterations.count > 1) within.frame.reset();
  const auto& part = selection.part = choose_part(meaning, value->type, within, where);
  if (iterations.count > 1) notes.frames = iterations.count;
  selection.value = *value;
  Grid grid = lattice_of(meaning, where);
  auto& rescale = selection.rescale = std::move(meaning.rescale);
  if (rescale.size() > 1) {  // of all frames
    const auto first = rescale.begin() + std::ptrdiff_t(part.frame) * grid.dims.z;
    rescale = std::vector(first, first + grid.dims.z);
  }
  grid.type = rescale.empty() || value->type == ScalarType::float64 ? value->type : ScalarType::float32;
  notes.labels = value->labels;
  if (notes.fill && rescale.size() == 1) {
    const double fill = rescale[0].slope * *notes.fill + rescale[0].intercept;
    notes.fill = grid.type == ScalarType::float32 ? double(float(fill)) : fill;
  }
  const int components = part.components;
  const auto channel = part.channel;
  if (components == 1) in_place = stored_in_place(dataset.get(), selection, dims);
  auto source = std::make_unique<DatasetSource>(interleaved_grid(grid, components, where), std::move(dataset),
                                                std::move(selection));
  return with_notes(channel_source(std::move(source), grid, components, channel), notes);
}

}  // namespace ringsplat::detail
