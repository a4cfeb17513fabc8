#include "formats/zarr/metadata.hpp"

#include <bit>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <glm/gtc/packing.hpp>
#include <numeric>

namespace ringsplat {
NLOHMANN_JSON_SERIALIZE_ENUM(World, {{World::lattice, "lattice"},
                                     {World::patient, "patient"},
                                     {World::microscope, "microscope"}})
}

namespace ringsplat::detail::zarr {
namespace {

Json read_json(const std::filesystem::path& file) {
  const InputFile regular(file);
  std::ifstream text(file);
  auto json = Json::parse(text, nullptr, false);
  if (json.is_discarded()) refuse(file, "copy or write the store again", "it is no JSON");
  return json;
}

const NumberType* type_of(const Node& node, std::string_view name) {
  if (const auto* const type = number_type(name)) return type;
  refuse(node.file, "only integers and floating-point numbers of at most 64 bits can be drawn",
         "its values are of type '{}'", excerpt(name));
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
  if (code == "f2") return double(glm::unpackHalf1x16(std::uint16_t(bits)));
  return code == "f4" ? double(std::bit_cast<float>(std::uint32_t(bits))) : std::bit_cast<double>(bits);
}

/// By a name of version 2, or of 3, where some are numcodecs' own.
void set_compressor(const Node& node, const std::string& name, Array& array) {
  using enum Compressor;
  constexpr std::pair<const char*, Compressor> compressors[] = {
      {"blosc", blosc}, {"zstd", zstd}, {"gzip", deflate}, {"zlib", deflate}, {"lz4", lz4}, {"xz", lzma}};
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

/// N5 (github.com/saalfeldlab/n5, "File-system specification") lists the fastest axis first.
void read_n5(const Node& node, Array& array) {
  const auto& json = node.json;
  array.n5 = array.big_endian = true;
  array.file = array.chunk = sizes_in(node, json.at("blockSize"));
  array.type = type_of(node, json.at("dataType").get<std::string>());
  array.separator = '/';
  const auto name = json.value("/compression/type"_json_pointer, "raw");
  if (name != "raw") set_compressor(node, name == "lz4" ? "LZ4 in frames" : name, array);
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

}  // namespace

std::optional<Node> node_at(const std::filesystem::path& folder) {
  for (const std::string name : {"zarr.json", ".zarray", ".zgroup", "attributes.json"}) {
    Node node{.folder = folder, .file = folder / name, .version_3 = name[0] == 'z', .n5 = name[0] == 'a'};
    if (!std::filesystem::exists(node.file)) continue;
    node.json = read_json(node.file);
    node.is_array = node.version_3 ? node.json.at("node_type") == "array"
                    : node.n5      ? node.json.contains("dimensions")
                                   : name == ".zarray";
    if (node.version_3)
      node.ome = node.json.value("/attributes/ome"_json_pointer, node.ome);
    else if (std::filesystem::exists(folder / ".zattrs"))
      node.ome = read_json(folder / ".zattrs");
    return node;
  }
  return {};
}

Sizes sizes_in(const Node& node, const Json& list, int least) {
  auto given = list.get<std::vector<double>>();
  if (node.n5) std::ranges::reverse(given);
  return mapped(given, [&](double size) {
    if (!(size >= least && size <= std::numeric_limits<int>::max() && size == std::trunc(size)))
      node.fail("{} is no size", size);
    return std::int64_t(size);
  });
}

Array array_of(const Node& node) {
  Array array;
  array.shape = sizes_in(node, node.json.at(node.n5 ? "dimensions" : "shape"));
  constexpr std::size_t most_axes = 16;
  if (array.shape.size() < 2 || array.shape.size() > most_axes)
    refuse(node.file, "name an array of three dimensions", "it has {} axes", array.shape.size());
  array.order.resize(array.shape.size());
  std::iota(array.order.begin(), array.order.end(), 0);
  if (node.n5)
    read_n5(node, array);
  else if (node.version_3)
    read_version_3(node, array);
  else
    read_version_2(node, array);
  array.chunk_bytes = array.type->bytes();
  array.fill = fill_of(node, array.type->code);
  check(node, array);
  return array;
}

void use_micrometres(DatasetMeaning& meaning) {
  for (const auto& axis : meaning.axes)
    if (axis.role == DatasetAxis::Role::space && !micrometres_in(axis.unit)) return;
  meaning.notes.unit = "um";
  for (auto& axis : meaning.axes) {
    axis.spacing *= micrometres_in(axis.unit).value_or(1);
    axis.first *= micrometres_in(axis.unit).value_or(1);
  }
}

void describe_axes(const Node& array, const Sizes& shape, DatasetMeaning& meaning) {
  const auto names = array.version_3 ? list_in(array.json, "dimension_names")
                     : array.n5      ? list_in(array.json, "axes")
                                     : list_in(array.ome, "_ARRAY_DIMENSIONS");
  for (std::size_t i = 0; i < shape.size(); ++i) {
    const auto k = array.n5 ? shape.size() - 1 - i : i;
    auto& axis = meaning.axes.emplace_back(DatasetAxis{.size = int(shape[i])});
    if (k < names.size() && names[k].is_string()) axis.name = lower_case(names[k]);
    describe_by_name(axis);
  }
}

Json lattice_to_json(const Grid& grid, const VolumeNotes& notes) {
  const auto list = [](const glm::dvec3& v) { return Json::array({v.x, v.y, v.z}); };
  Json json{{"world", notes.world},       {"unit", notes.unit},     {"quantity", notes.quantity},
            {"modality", notes.modality}, {"labels", notes.labels}, {"origin", list(grid.origin)}};
  for (int k = 0; k < 3; ++k) json["directions"].push_back(list(grid.direction[k]));
  if (notes.fill) json["fill"] = *notes.fill;  // JSON's null is not-a-number
  return json;
}

void describe_lattice(const Json& json, DatasetMeaning& meaning) {
  const auto vector = [](const Json& list) {
    return glm::dvec3(list.at(0).get<double>(), list.at(1).get<double>(), list.at(2).get<double>());
  };
  auto& notes = meaning.notes;
  notes.world = json.at("world").get<World>();
  notes.unit = json.at("unit").get<std::string>();
  notes.quantity = json.at("quantity").get<std::string>();
  notes.modality = json.at("modality").get<std::string>();
  notes.labels = json.at("labels").get<bool>();
  if (json.contains("fill")) notes.fill = json["fill"].is_null() ? std::nan("") : json["fill"].get<double>();
  meaning.direction.emplace();
  meaning.origin = vector(json.at("origin"));
  for (int k = 0; k < 3; ++k) {
    (*meaning.direction)[k] = vector(json.at("directions").at(std::size_t(k)));
    *meaning.origin += (*meaning.direction)[k] * meaning.axes.at(std::size_t(2 - k)).first;
  }
}

void describe_steps(const Json& json, DatasetMeaning& meaning) {
  const auto steps = json.contains("resolution")
                         ? json["resolution"]
                         : json.value("/pixelResolution/dimensions"_json_pointer, Json::array());
  const auto units = list_in(json, "units");
  for (std::size_t k = 0; k < std::min(steps.size(), meaning.axes.size()); ++k) {
    auto& axis = meaning.axes[meaning.axes.size() - 1 - k];
    axis.spacing = steps[k].get<double>();
    axis.unit =
        k < units.size() ? units[k].get<std::string>() : json.value("/pixelResolution/unit"_json_pointer, "");
  }
  use_micrometres(meaning);
}

}  // namespace ringsplat::detail::zarr
