#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "base/byte_order.hpp"
#include "base/input_file.hpp"
#include "base/text.hpp"
#include "formats/axes.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "formats/volume_files.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

using Role = DatasetAxis::Role;
using Json = nlohmann::json;
/// Sizes or places along the axes of an array, the last of which is the fastest.
using Sizes = std::vector<std::int64_t>;

/// A group or an array, by its files of JSON (Zarr storage specification, versions 2 and 3).
struct Node {
  std::filesystem::path folder, file;
  bool version_3 = false, is_array = false;
  Json json;
  Json ome = Json::object();  ///< what OME-Zarr says of an image; in version 2 all attributes

  bool is_image() const { return !is_array && ome.contains("/multiscales/0"_json_pointer); }
  template <class... Args>
  [[noreturn]] void fail(fmt::format_string<Args...> what, Args&&... args) const {
    refuse(file, "copy or write the store again", what, std::forward<Args>(args)...);
  }
};

struct Array {
  Sizes shape, chunk;
  Sizes file;  ///< the voxels in a file, a chunk's or a shard's, of which a chunk is a whole part
  const NumberType* type = nullptr;
  double fill = 0;
  Sizes order;  ///< the axes as a chunk holds them, the slowest first
  bool big_endian = false;
  Compressor compressor = Compressor::none;
  std::uint64_t checksum = 0;  ///< bytes behind a chunk, which are not looked at
  bool sharded = false, index_first = false;
  std::uint64_t index_checksum = 0;
  std::string prefix, separator;  ///< of files' names, before and between the numbers
  std::uint64_t chunk_bytes = 0;  ///< decoded
  std::uint64_t chunks = 1;       ///< of a file
};

Json read_json(const std::filesystem::path& file) {
  const InputFile regular(file);
  std::ifstream text(file);
  auto json = Json::parse(text, nullptr, false);
  if (json.is_discarded()) refuse(file, "copy or write the store again", "it is no JSON");
  return json;
}

/// Nothing where the folder is neither.
std::optional<Node> node_at(const std::filesystem::path& folder) {
  for (const std::string name : {"zarr.json", ".zarray", ".zgroup"}) {
    Node node{.folder = folder, .file = folder / name, .version_3 = name[0] != '.', .json = {}};
    if (!std::filesystem::exists(node.file)) continue;
    node.json = read_json(node.file);
    node.is_array = node.version_3 ? node.json.at("node_type") == "array" : name == ".zarray";
    if (node.version_3)
      node.ome = node.json.value("/attributes/ome"_json_pointer, node.ome);
    else if (std::filesystem::exists(folder / ".zattrs"))
      node.ome = read_json(folder / ".zattrs");
    return node;
  }
  return {};
}

/// The list of that name; an empty one where there is none.
Json list_in(const Json& json, const char* name) { return json.value(name, Json::array()); }

/// The text of that name; empty where there is none.
std::string text_in(const Json& json, const char* name) {
  const auto text = json.value(name, Json());
  return text.is_string() ? text.get<std::string>() : std::string();
}

Sizes sizes_in(const Node& node, const Json& list, int least = 1) {
  Sizes sizes;
  for (const double size : list.get<std::vector<double>>()) {
    if (!(size >= least && size <= std::numeric_limits<int>::max() && size == std::trunc(size)))
      node.fail("{} is no size", size);
    sizes.push_back(std::int64_t(size));
  }
  return sizes;
}

const NumberType* type_of(const Node& node, std::string_view name) {
  if (const auto* const type = number_type(name)) return type;
  refuse(node.file, "only integers and floating-point numbers of at most 64 bits can be drawn",
         "its values are of type '{}'", excerpt(std::string(name)));
}

/// A number, a truth value, "NaN", "Infinity", "-Infinity" or a float's bits ("0x7fc00000"); null where
/// nobody cares.
double fill_of(const Node& node, std::string_view code) {
  const auto json = node.json.value("fill_value", Json());
  if (json.is_null() || json.is_boolean()) return json == true ? 1 : 0;
  const auto text = json.is_string() ? json.get<std::string>() : json.dump();
  if (const auto number = number_in<double>(text)) return *number;
  if (!text.starts_with("0x")) node.fail("its fill value is '{}'", excerpt(text));
  const auto bits = std::strtoull(text.c_str(), nullptr, 16);
  if (code == "f2") return double(float_of_half(std::uint16_t(bits)));
  return code == "f4" ? double(std::bit_cast<float>(std::uint32_t(bits))) : std::bit_cast<double>(bits);
}

/// By a name of version 2, or of 3, where some are numcodecs' own.
void set_compressor(const Node& node, const std::string& name, Array& array) {
  using enum Compressor;
  constexpr std::pair<const char*, Compressor> compressors[] = {
      {"blosc", blosc}, {"zstd", zstd}, {"gzip", deflate}, {"zlib", deflate}, {"lz4", lz4}};
  for (const auto& [known, compressor] : compressors)
    if (name == known || name == fmt::format("numcodecs.{}", known))
      if (std::exchange(array.compressor, compressor) == none && array.checksum == 0) return;
  refuse(node.file, "write it anew, compressed by blosc, zstd, gzip, zlib, lz4 or not at all",
         "its codec '{}' is not read there", excerpt(name));
}

/// Of files' chunks, or, within shards, of theirs.
void read_codecs(const Node& node, const Json& codecs, Array& array) {
  constexpr std::uint64_t crc_bytes = 4;
  const auto plain = array.order;
  for (const auto& codec : codecs) {
    const auto name = codec.at("name").get<std::string>();
    const auto how = codec.value("configuration", Json::object());
    if (name == "transpose" && array.order == plain) {
      array.order = sizes_in(node, how.at("order"), 0);
      if (!std::ranges::is_permutation(array.order, plain)) node.fail("it transposes other axes than it has");
    } else if (name == "bytes") {
      array.big_endian = how.value("endian", "little") == "big";
    } else if (name == "crc32c") {
      array.checksum += crc_bytes;
    } else if (name == "sharding_indexed" && !array.sharded && array.order == plain) {
      array.sharded = true;
      array.chunk = sizes_in(node, how.at("chunk_shape"));
      read_codecs(node, how.at("codecs"), array);
      array.index_first = how.value("index_location", "end") == "start";
      for (const auto& of_index : how.at("index_codecs"))
        if (of_index.at("name") == "crc32c") array.index_checksum = crc_bytes;
    } else {
      set_compressor(node, name, array);
    }
  }
}

void read_version_2(const Node& node, Array& array) {
  const auto& json = node.json;
  array.file = array.chunk = sizes_in(node, json.at("chunks"));
  const auto type = json.at("dtype").get<std::string>();
  array.type = type_of(node, std::string_view(type).substr(type.empty() ? 0 : 1));
  array.big_endian = type[0] == '>';
  if (json.value("order", "C") == "F") std::ranges::reverse(array.order);
  if (json.contains("/filters/0"_json_pointer))
    refuse(node.file, "write it without filters", "its filters change the values");
  if (json.contains("/compressor/id"_json_pointer)) set_compressor(node, json["compressor"]["id"], array);
  array.separator = json.value("dimension_separator", ".");
}

void read_version_3(const Node& node, Array& array) {
  const auto& json = node.json;
  array.file = array.chunk = sizes_in(node, json.at("/chunk_grid/configuration/chunk_shape"_json_pointer));
  array.type = type_of(node, json.at("data_type").get<std::string>());
  read_codecs(node, json.at("codecs"), array);
  const auto& keys = json.at("chunk_key_encoding");
  const bool as_before = keys.at("name") == "v2";
  array.separator = keys.value("/configuration/separator"_json_pointer, as_before ? "." : "/");
  if (!as_before) array.prefix = "c" + array.separator;
}

void check(const Node& node, Array& array) {
  constexpr std::uint64_t most = std::uint64_t{4} << 30;
  const auto axes = array.shape.size();
  if (array.separator != "." && array.separator != "/")  // others could lead anywhere
    node.fail("'{}' is no separator of numbers", excerpt(array.separator));
  for (std::size_t k = 0; k < axes; ++k) {
    if (array.file.size() != axes || array.chunk.size() != axes || array.file[k] % array.chunk[k] != 0)
      node.fail("its shape does not fit its chunks");
    // Neither product overflows, as a size has 31 bits.
    array.chunk_bytes *= std::uint64_t(array.chunk[k]);
    array.chunks *= std::uint64_t(array.file[k] / array.chunk[k]);
    if (array.chunk_bytes > most || array.chunks > most)
      node.fail("its chunks are too large, or too many in a file");
  }
  visit_type(array.type->type, [&](auto zero) {
    using Limits = std::numeric_limits<decltype(zero)>;
    if (Limits::is_integer &&
        !(array.fill >= double(Limits::lowest()) && array.fill <= double(Limits::max())))
      node.fail("its fill value is {}, which {} does not hold", array.fill, array.type->name);
  });
}

Array array_of(const Node& node) {
  Array array;
  array.shape = sizes_in(node, node.json.at("shape"));
  constexpr std::size_t most_axes = 16;
  if (array.shape.size() < 2 || array.shape.size() > most_axes)
    refuse(node.file, "name an array of three dimensions", "it has {} axes", array.shape.size());
  array.order.resize(array.shape.size());
  std::iota(array.order.begin(), array.order.end(), 0);
  if (node.version_3)
    read_version_3(node, array);
  else
    read_version_2(node, array);
  array.chunk_bytes = array.type->bytes();
  array.fill = fill_of(node, array.type->code);
  check(node, array);
  return array;
}

/// The file that holds a place.
std::filesystem::path file_of(const Node& node, const Array& array, const Sizes& place) {
  std::string name = array.prefix;
  for (std::size_t k = 0; k < place.size(); ++k)
    name += fmt::format("{}{}", k == 0 ? "" : array.separator, place[k] / array.file[k]);
  return node.folder / name;
}

/// The metadata and the first chunk stand for all files.
std::vector<std::filesystem::path> files_of(const Node& node, const Array& array, const ArrayPart& part) {
  std::vector<std::filesystem::path> files{node.file, file_of(node, array, part.first)};
  if (!std::filesystem::exists(files.back())) files.pop_back();
  return files;
}

/// Calls f for the places from `first` on that lie before `end` along each axis, in steps.
template <class F>
void for_each_place(const Sizes& first, const Sizes& end, const Sizes& step, F&& f) {
  Sizes at = first;
  for (auto k = at.size(); k > 0;) {
    f(at);
    for (k = at.size(); k > 0 && (at[k - 1] += step[k - 1]) >= end[k - 1]; --k) at[k - 1] = first[k - 1];
  }
}

/// Part of an array as a volume. Holds one chunk, decoded and as its file has it, beside the layer of chunks
/// that is asked for.
class ZarrSource final : public LayeredSource {
 public:
  ZarrSource(const Grid& grid, const Node& node, Array array, const ArrayPart& part)
      : LayeredSource(grid, files_of(node, array, part), {{"encoding", "Zarr"}}),
        node_(node),
        array_(std::move(array)),
        part_(part),
        from_(array_.shape.size()),
        to_(array_.shape.size(), 1) {
    std::int64_t step = 1;
    for (auto k = from_.size(); k > 0; --k) {
      const auto axis = std::size_t(array_.order[k - 1]);
      from_[axis] = step;
      step *= array_.chunk[axis];
    }
    // Interleaved numbers lie beside each other; of other axes than these only one value is taken.
    const std::int64_t steps[] = {part.components, grid.dims.x, std::int64_t{grid.dims.x} * grid.dims.y};
    for (std::size_t k = 0; k < 3; ++k)
      if (part.lattice[k] >= 0) to_[std::size_t(part.lattice[k])] = steps[k];
    if (part.lattice[2] >= 0) set_layer(std::uint64_t(array_.chunk[std::size_t(part.lattice[2])]));
  }

 private:
  void read_layer(int begin, int stop, std::span<std::byte> out) override {
    const auto z = part_.lattice[2];
    if (z >= 0) part_.first[std::size_t(z)] = begin, part_.end[std::size_t(z)] = stop;
    Sizes first = part_.first;
    for (std::size_t k = 0; k < first.size(); ++k) first[k] -= first[k] % array_.chunk[k];
    visit_type(grid().type, [&](auto zero) {
      auto* const voxels = reinterpret_cast<decltype(zero)*>(out.data());
      for_each_place(first, part_.end, array_.chunk, [&](const Sizes& chunk) { copy(chunk, voxels); });
    });
  }

  /// What a chunk has of the part, row by row along the last axis. `chunk`: its first place. `to`: the part's
  /// first voxel.
  template <class T>
  void copy(const Sizes& chunk, T* to) {
    const bool there = decode(chunk);
    const T fill = T(array_.fill);
    Sizes first = part_.first, end = part_.end;
    for (std::size_t k = 0; k < chunk.size(); ++k) {
      first[k] = std::max(first[k], chunk[k]);
      end[k] = std::min(end[k], chunk[k] + array_.chunk[k]);
    }
    const auto count = end.back() - first.back(), step = there ? from_.back() : 0;
    Sizes rows(chunk.size(), 1);
    rows.back() = count;
    for_each_place(first, end, rows, [&](const Sizes& at) {
      const T* value = there ? reinterpret_cast<const T*>(values_.data()) : &fill;
      T* voxel = to;
      for (std::size_t k = 0; k < at.size(); ++k) {
        value += there ? (at[k] - chunk[k]) * from_[k] : 0;
        voxel += (at[k] - part_.first[k]) * to_[k];
      }
      if (step == 1 && to_.back() == 1) return void(std::copy_n(value, count, voxel));
      for (auto i = count; i > 0; --i, value += step, voxel += to_.back()) *voxel = *value;
    });
  }

  /// Makes `values_` those of a chunk; false when it is not there.
  bool decode(const Sizes& chunk) {
    if (held_ == chunk) return true;
    held_.clear();
    const auto path = file_of(node_, array_, chunk);
    std::error_code unknown;  // it may be there, and opening it says why it cannot be read
    if (!std::filesystem::exists(path, unknown) && !unknown) return false;
    if (!file_ || file_->path() != path) file_.emplace(path);
    std::uint64_t offset = 0, bytes = file_->size();
    if (array_.sharded && !find_in_shard(chunk, offset, bytes)) return false;
    if (offset > file_->size() || bytes > file_->size() - offset || bytes < array_.checksum)
      fail("do not lie within it");
    unpack(offset, bytes - array_.checksum);
    held_ = chunk;
    return true;
  }

  /// By the shard's index; false when it says that the chunk is not there.
  bool find_in_shard(const Sizes& chunk, std::uint64_t& offset, std::uint64_t& bytes) {
    std::int64_t number = 0;
    for (std::size_t k = 0; k < chunk.size(); ++k)
      number = (number * array_.file[k] + chunk[k] % array_.file[k]) / array_.chunk[k];
    std::array<std::uint64_t, 2> place{};
    const auto index = array_.chunks * sizeof(place) + array_.index_checksum;
    if (bytes < index) fail("are not all in its index, which is cut short");
    const auto out = std::as_writable_bytes(std::span(place));
    file_->read((array_.index_first ? 0 : bytes - index) + std::uint64_t(number) * sizeof(place), out);
    to_native_order(out, sizeof(place[0]), false);
    offset = place[0];
    bytes = place[1];
    return (offset & bytes) != ~std::uint64_t{0};
  }

  void unpack(std::uint64_t offset, std::uint64_t bytes) {
    require_compressed_bytes(file_->path(), bytes, array_.chunk_bytes, any_best_ratio);
    values_.resize(std::size_t(array_.chunk_bytes));
    if (array_.compressor == Compressor::deflate) {
      const auto inflated = encoded_bytes(*file_, Encoding::deflate, offset);
      inflated->read(0, values_);
      inflated->verify_end();
    } else {
      // numcodecs writes four bytes with the size before its LZ4 blocks.
      const std::uint64_t before = array_.compressor == Compressor::lz4 ? 4 : 0;
      packed_.resize(std::size_t(bytes - std::min(bytes, before)));
      file_->read(offset + before, packed_);
      if (!decompress(array_.compressor, packed_, values_))
        fail("are damaged, or not of the size that the metadata say");
    }
    to_native_order(values_, array_.type->bytes(), array_.big_endian);
    const auto code = array_.type->code;
    if (code == "i8" || code == "u8") doubles_of_integers(values_, code == "i8", file_->path().string());
    if (code != "f2") return;
    packed_.resize(2 * values_.size());
    widen_halves(values_, packed_);
    values_.swap(packed_);
  }

  [[noreturn]] void fail(const char* what) const {
    refuse(file_->path(), "copy or write the file again", "its chunks {}", what);
  }

  Node node_;
  Array array_;
  ArrayPart part_;   ///< of the layer that was read last
  Sizes from_, to_;  ///< steps from one value to the next along each axis, in a chunk and in a layer
  std::optional<InputFile> file_;  ///< that was read last
  Sizes held_;                     ///< the chunk that `values_` are of
  std::vector<std::byte> packed_, values_;
};

/// By what OME-Zarr says of an image and its level. Lengths are made micrometres where all have units.
void describe(const Node& group, const Json& image, const Json& level, DatasetMeaning& meaning) {
  auto& axes = meaning.axes;
  const auto described = list_in(image, "axes");
  if (described.size() != axes.size()) group.fail("its axes do not fit the array");
  for (std::size_t k = 0; k < axes.size(); ++k) {
    const auto type = text_in(described[k], "type");
    axes[k].name = type.empty() || type == "space" ? lower_case(described[k].at("name")) : type;
    axes[k].unit = text_in(described[k], "unit");
    describe_by_name(axes[k]);
  }
  for (const auto& said : {level, image})
    for (const auto& change : list_in(said, "coordinateTransformations")) {
      const auto scale = change.value("scale", std::vector<double>(axes.size(), 1)),
                 shift = change.value("translation", std::vector<double>(axes.size(), 0));
      if (scale.size() != axes.size() || shift.size() != axes.size())
        group.fail("its scales and translations do not fit its axes");
      for (std::size_t k = 0; k < axes.size(); ++k) {
        axes[k].spacing *= scale[k];
        axes[k].first = axes[k].first * scale[k] + shift[k];
      }
    }
  meaning.notes.world = World::microscope;
  meaning.notes.labels |= group.ome.contains("image-label");
  for (const auto& channel : group.ome.value("/omero/channels"_json_pointer, Json::array()))
    meaning.channels.push_back(text_in(channel, "label"));
  for (const auto& axis : axes)
    if (axis.role == Role::space && !micrometres_in(axis.unit)) return;
  meaning.notes.unit = "um";
  for (auto& axis : axes) {
    axis.spacing *= micrometres_in(axis.unit).value_or(1);
    axis.first *= micrometres_in(axis.unit).value_or(1);
  }
}

/// Where a level of an image lies.
std::filesystem::path folder_of(const Node& image, const std::string& level) {
  const auto path = std::filesystem::path(level).lexically_normal();
  if (path.is_absolute() || path.string().starts_with(".."))
    image.fail("its level '{}' leads out of the store", excerpt(level));
  return std::filesystem::weakly_canonical(image.folder / path);
}

/// The only image or array in a group.
Node only_one(const Node& group) {
  std::vector<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(group.folder)) {
    const auto node = entry.is_directory() ? node_at(entry.path()) : std::nullopt;
    if (node && (node->is_array || node->is_image())) found.push_back(entry.path().filename().string());
  }
  if (found.size() == 1) return *node_at(group.folder / found.front());
  std::ranges::sort(found);
  refuse(group.folder, "name the folder of an array or an image", "the group holds {}",
         found.empty() ? "none" : "several: " + comma_list(found));
}

/// By the axes' names: an attribute of xarray's in version 2.
void describe_axes(const Node& array, DatasetMeaning& meaning) {
  const auto names =
      array.version_3 ? list_in(array.json, "dimension_names") : list_in(array.ome, "_ARRAY_DIMENSIONS");
  for (const auto size : sizes_in(array, array.json.at("shape"))) {
    const auto k = meaning.axes.size();
    auto& axis = meaning.axes.emplace_back(DatasetAxis{.size = int(size)});
    if (k < names.size() && names[k].is_string()) axis.name = lower_case(names[k]);
    describe_by_name(axis);
  }
}

/// The array at a path, or the finest level of the image there, and what its axes mean: by the image in a
/// group above of which it is a level, else by their names.
Node find_array(const std::filesystem::path& path, DatasetMeaning& meaning) {
  Node node = *node_at(std::filesystem::canonical(path));
  if (!node.is_array && !node.is_image()) node = only_one(node);
  constexpr int most_above = 3;
  auto above = node.folder;
  for (int k = 0; k <= most_above; ++k, above = above.parent_path()) {
    const auto group = node_at(above);
    if (!group || !group->is_image()) continue;
    for (const auto& image : group->ome["multiscales"])
      for (const auto& level : list_in(image, "datasets")) {
        const auto name = level.at("path").get<std::string>();
        const auto folder = folder_of(*group, name);
        if (node.is_array && node.folder != folder) continue;
        const auto array = node_at(folder);
        if (!array || !array->is_array) group->fail("its level '{}' leads to no array", excerpt(name));
        describe_axes(*array, meaning);
        describe(*group, image, level, meaning);
        return *array;
      }
  }
  describe_axes(node, meaning);
  return node;
}

/// Throws InputError when the files cannot hold so many bytes. Looks at as few of them as show it.
void require_chunks(const Node& node, std::uint64_t bytes) {
  std::uint64_t packed = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(node.folder)) {
    if (entry.is_regular_file()) packed += entry.file_size();
    if (packed > bytes / any_best_ratio) return;
  }
  require_compressed_bytes(node.folder, packed, bytes, any_best_ratio);
}

}  // namespace

std::unique_ptr<VolumeSource> open_zarr(const std::filesystem::path& path, const VolumeChoice& choice) try {
  const auto where = path.string();
  DatasetMeaning meaning;
  const Node node = find_array(path, meaning);
  const Array array = array_of(node);
  meaning.notes.labels |= array.type->code == "b1";
  settle_roles(meaning, where, "name them by _ARRAY_DIMENSIONS or dimension_names, such as t, c, z, y, x");
  const auto part = choose_part(meaning, array.type->type, choice, where);
  Grid grid = lattice_of(meaning, where);
  grid.type = array.type->type;
  if (meaning.notes.world == World::microscope) {
    grid.direction = microscope_axes * grid.direction;
    grid.origin = microscope_axes * grid.origin;
  }
  const Grid read = interleaved_grid(grid, part.components, where);
  require_chunks(node, read.bytes());
  auto source = std::make_unique<ZarrSource>(read, node, array, part);
  return with_notes(channel_source(std::move(source), grid, part.components, part.channel), meaning.notes);
} catch (const Json::exception& error) {
  refuse(path, "copy or write the store again", "its metadata cannot be read: {}", error.what());
}

}  // namespace ringsplat::detail
