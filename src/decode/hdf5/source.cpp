#include "decode/hdf5/source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "base/input_file.hpp"
#include "formats/limits.hpp"
#include "formats/volume_files.hpp"

namespace ringsplat::detail::hdf5 {
namespace {

/// Bytes of a layer that a process holds while it hands it out.
constexpr std::uint64_t most_layer_bytes = std::uint64_t{256} << 20;
constexpr int most_dimensions = H5S_MAX_RANK;

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
      throw InputError(
          fmt::format("{}: its chunks went through the filter {} ({}), which HDF5 does not have here", where,
                      filter_name(id, name), int(id)),
          "set HDF5_PLUGIN_PATH to a folder with its plugin, or h5repack -f GZIP=4 IN OUT where it is");
  }
}

hid_t memory_type(ScalarType type) {
  switch (type) {
    case ScalarType::int8:
      return H5T_NATIVE_INT8;
    case ScalarType::uint8:
      return H5T_NATIVE_UINT8;
    case ScalarType::int16:
      return H5T_NATIVE_INT16;
    case ScalarType::uint16:
      return H5T_NATIVE_UINT16;
    case ScalarType::int32:
      return H5T_NATIVE_INT32;
    case ScalarType::uint32:
      return H5T_NATIVE_UINT32;
    case ScalarType::float32:
      return H5T_NATIVE_FLOAT;
    case ScalarType::float64:
      break;
  }
  return H5T_NATIVE_DOUBLE;
}

std::vector<hsize_t> chunk_of(hid_t creation, std::size_t rank) {
  std::vector<hsize_t> chunk(rank, 0);
  if (H5Pget_layout(creation) != H5D_CHUNKED || H5Pget_chunk(creation, int(rank), chunk.data()) != int(rank))
    return {};
  return chunk;
}

class DatasetSource final : public VolumeSource {
 public:
  DatasetSource(const Grid& grid, VolumeNotes notes, Selection selection)
      : grid_(grid), notes_(std::move(notes)), selection_(std::move(selection)), on_disk_(selection_.file) {
    const Quiet quiet;
    file_ = open_file(selection_.file);
    const Id access(H5Pcreate(H5P_DATASET_ACCESS));
    // Whole layers are read at once, so no chunk is asked for twice.
    H5Pset_chunk_cache(access.get(), 0, 0, 0);
    dataset_ = made(H5Dopen2(file_.get(), selection_.dataset.c_str(), access.get()), where());
    const Id creation = made(H5Dget_create_plist(dataset_.get()), where());
    chunk_ = chunk_of(creation.get(), selection_.first.size());
    if (!chunk_.empty() && selection_.slices >= 0) depth_ = bounded(chunk_[std::size_t(selection_.slices)]);
  }
  ~DatasetSource() override {
    const Quiet quiet;
    dataset_ = Id();
    file_ = Id();
  }

  const Grid& grid() const override { return grid_; }
  bool concurrent() const override { return true; }
  int layer_depth() const override { return depth_; }
  VolumeNotes notes() const override { return notes_; }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const std::size_t bytes = grid_.slice_bytes(Axis::z);
    for (int z = first; z < first + count;) {
      const int begin = z / depth_ * depth_, end = std::min(begin + depth_, grid_.dims.z),
                stop = std::min(end, first + count);
      const auto part = out.subspan(std::size_t(z - first) * bytes, std::size_t(stop - z) * bytes);
      if (z == begin && stop == end) {
        read_layer(begin, end, part);
      } else {
        if (kept_first_ != begin) {
          kept_first_ = -1;
          kept_.resize(std::size_t(end - begin) * bytes);
          read_layer(begin, end, kept_);
          kept_first_ = begin;
        }
        std::memcpy(part.data(), kept_.data() + std::size_t(z - begin) * bytes, part.size());
      }
      z = stop;
    }
  }

  Facts facts() const override {
    std::string chunk, first;
    for (const hsize_t size : chunk_) chunk += fmt::format("{}{}", chunk.empty() ? "" : " x ", size);
    for (const hsize_t at : selection_.first) first += fmt::format("{}{}", first.empty() ? "" : " ", at);
    Facts facts{{"encoding", "HDF5"},
                {"dataset", selection_.dataset},
                {"stored type", selection_.value.name},
                {"first voxel", first},
                {"chunks", chunk.empty() ? "none" : chunk}};
    if (!selection_.rescale.empty())
      facts.push_back({"rescale", fmt::format("{:.17g} {:.17g}", selection_.rescale.front().slope,
                                              selection_.rescale.front().intercept)});
    add_facts_of(on_disk_, 0, on_disk_.size(), facts);
    return facts;
  }

 private:
  std::string where() const { return selection_.file.string() + ":" + selection_.dataset; }

  /// A layer of chunks in layers of at most most_layer_bytes, as even as they can be.
  int bounded(hsize_t layer) const {
    const auto depth = std::uint64_t(std::min<hsize_t>(layer, hsize_t(grid_.dims.z)));
    const std::uint64_t most = std::max<std::uint64_t>(1, most_layer_bytes / grid_.slice_bytes(Axis::z));
    const std::uint64_t parts = (depth + most - 1) / most;
    return int((depth + parts - 1) / parts);
  }

  void read_layer(int begin, int end, std::span<std::byte> out) {
    on_disk_.require_unchanged();
    const Quiet quiet;
    if (!selection_.rescale.empty()) {
      std::vector<double> values(out.size() / size_of(grid_.type));
      read_as(H5T_NATIVE_DOUBLE, begin, end, values.data());
      visit_type(grid_.type, [&](auto zero) {
        auto* result = reinterpret_cast<decltype(zero)*>(out.data());
        const std::size_t slice = values.size() / std::size_t(end - begin);
        for (std::size_t i = 0; i < values.size(); ++i) {
          const auto z = selection_.rescale.size() > 1 ? std::size_t(begin) + i / slice : 0;
          const Rescale& rescale = selection_.rescale[z];
          *result++ = decltype(zero)(rescale.slope * values[i] + rescale.intercept);
        }
      });
    } else if (selection_.value.wide) {
      read_wide(begin, end, out);
    } else {
      read_as(memory_type(grid_.type), begin, end, out.data());
    }
    on_disk_.require_unchanged();
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
        throw InputError(fmt::format("{}: the 64-bit integer {}{} has no exact float64", where(),
                                     negative ? "-" : "", magnitude),
                         "convert the dataset to 32-bit integers or floats first");
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
    const Id stored = made(H5Dget_space(dataset_.get()), where());
    done(H5Sselect_hyperslab(stored.get(), H5S_SELECT_SET, first.data(), nullptr, size.data(), nullptr),
         where());
    const Id memory = made(H5Screate_simple(int(size.size()), size.data(), nullptr), where());
    if (H5Dread(dataset_.get(), type, memory.get(), stored.get(), H5P_DEFAULT, out) < 0)
      fail(fmt::format("{}: slices {} to {} cannot be read", where(), begin, end - 1));
  }

  Grid grid_;
  VolumeNotes notes_;
  Selection selection_;
  InputFile on_disk_;
  Id file_, dataset_;
  std::vector<hsize_t> chunk_;  ///< sizes; empty for a dataset without chunks
  int depth_ = 1;
  std::vector<std::byte> kept_;  ///< the last layer that was not read as a whole
  int kept_first_ = -1;
};

}  // namespace

void require_readable(hid_t dataset, const std::filesystem::path& file, const std::string& where) {
  const Id creation = made(H5Dget_create_plist(dataset), where);
  const H5D_layout_t layout = H5Pget_layout(creation.get());
  if (layout == H5D_VIRTUAL)
    throw InputError(fmt::format("{}: a virtual dataset, whose voxels other datasets hold", where),
                     "h5repack IN OUT writes them into one file");
  if (layout < 0) fail(fmt::format("{}: its layout cannot be read", where));
  if (H5Pget_external_count(creation.get()) != 0)
    throw InputError(fmt::format("{}: its voxels lie in other files", where),
                     "h5repack IN OUT writes them into one file");
  require_filters(creation.get(), where);
  const auto dims = dims_of(dataset);
  const Id type = made(H5Dget_type(dataset), where);
  std::uint64_t bytes = H5Tget_size(type.get());
  for (const int size : dims) {
    if (bytes > (std::uint64_t{1} << 62) / std::uint64_t(size))
      throw InputError(fmt::format("{}: its dimensions are too large for any file", where), "write it again");
    bytes *= std::uint64_t(size);
  }
  const InputFile on_disk(file);
  const std::uint64_t stored = H5Dget_storage_size(dataset);
  if (stored == 0)
    throw InputError(fmt::format("{}: its voxels were never written", where),
                     "write them, or name another dataset");
  if (layout == H5D_CONTIGUOUS) {
    const haddr_t at = H5Dget_offset(dataset);
    if (at == HADDR_UNDEF) fail(fmt::format("{}: its voxels' place cannot be read", where));
    require_bytes(file, on_disk.size(), at, bytes);
  }
  if (layout != H5D_CHUNKED) return;
  require_compressed_bytes(file, on_disk.size(), bytes, any_best_ratio);
  std::uint64_t chunk_bytes = H5Tget_size(type.get());
  const auto chunk = chunk_of(creation.get(), dims.size());
  if (chunk.empty()) fail(fmt::format("{}: its chunks' sizes cannot be read", where));
  for (const hsize_t size : chunk) chunk_bytes *= size;
  require_compressed_bytes(file, on_disk.size(), chunk_bytes, any_best_ratio);
}

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

std::unique_ptr<VolumeSource> dataset_source(const Grid& grid, VolumeNotes notes, Selection selection) {
  return std::make_unique<DatasetSource>(grid, std::move(notes), std::move(selection));
}

}  // namespace ringsplat::detail::hdf5
