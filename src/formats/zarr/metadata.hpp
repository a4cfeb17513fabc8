#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/axes.hpp"
#include "formats/encoded_bytes.hpp"
#include "formats/limits.hpp"

namespace ringsplat::detail::zarr {

using Json = nlohmann::json;
/// Sizes or places along the axes of an array, the last of which is the fastest.
using Sizes = std::vector<std::int64_t>;

/// A group or an array, by its files of JSON (Zarr storage specification, versions 2 and 3; N5).
struct Node {
  std::filesystem::path folder, file;
  bool version_3 = false, n5 = false, is_array = false;
  Json json = {};
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
  Sizes order;      ///< the axes as a chunk holds them, the slowest first
  bool n5 = false;  ///< chunks begin with their sizes, and files' names have the axes the other way round
  bool big_endian = false;
  Compressor compressor = Compressor::none;
  std::uint64_t checksum = 0;  ///< bytes behind a chunk, which are not looked at
  bool sharded = false, index_first = false;
  std::uint64_t index_checksum = 0;
  std::string prefix, separator;  ///< of files' names, before and between the numbers
  std::uint64_t chunk_bytes = 0;  ///< decoded
  std::uint64_t chunks = 1;       ///< of a file
};

/// Nothing where the folder is neither.
std::optional<Node> node_at(const std::filesystem::path& folder);
/// The list of that name; an empty one where there is none.
inline Json list_in(const Json& json, const char* name) { return json.value(name, Json::array()); }
/// The text of that name; empty where there is none.
inline std::string text_in(const Json& json, const char* name) {
  const auto text = json.value(name, Json());
  return text.is_string() ? text.get<std::string>() : std::string();
}

/// Whole numbers from `least` on, the slowest axis' first. Throws InputError where they are not.
Sizes sizes_in(const Node& node, const Json& list, int least = 1);
/// What an array's metadata say. Throws InputError for what is not read, and Json::exception where something
/// is missing or of another type.
Array array_of(const Node& node);
/// The part of an array as a volume of this grid, its numbers interleaved where it has several a voxel.
/// `facts`: beside the grid's and the files'.
std::unique_ptr<VolumeSource> array_source(const Grid& grid, const Node& node, Array array,
                                           const ArrayPart& part, Facts facts);

/// Makes lengths micrometres where all have units.
void use_micrometres(DatasetMeaning& meaning);
/// Adds the array's axes by their names, which are an attribute of xarray's in version 2.
void describe_axes(const Node& array, const Sizes& shape, DatasetMeaning& meaning);
/// What an image that this program wrote says of its lattice and values beside OME's axes.
Json lattice_to_json(const Grid& grid, const VolumeNotes& notes);
/// Sets what lattice_to_json() told, the origin moved by what OME's axes say of the level. Throws
/// Json::exception where something is missing.
void describe_lattice(const Json& json, DatasetMeaning& meaning);
/// What programs write beside an N5 array: steps and their units, along the fastest axis first.
void describe_steps(const Json& json, DatasetMeaning& meaning);

}  // namespace ringsplat::detail::zarr
