#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/byte_order.hpp"
#include "base/hex_colour.hpp"
#include "base/input_file.hpp"
#include "base/log.hpp"
#include "base/process.hpp"
#include "base/text.hpp"
#include "formats/axes.hpp"
#include "formats/binary_fields.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "formats/stored_source.hpp"
#include "formats/volume_files.hpp"
#include "formats/zarr/metadata.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

using namespace zarr;
using Role = DatasetAxis::Role;

/// A GP may hold its slices along three axes.
constexpr int slice_sets = 3;

std::filesystem::path file_of(const Node& node, const Array& array, const Sizes& place) {
  std::string name = array.prefix;
  for (std::size_t i = 0; i < place.size(); ++i) {
    const auto k = array.n5 ? place.size() - 1 - i : i;
    name += fmt::format("{}{}", i == 0 ? "" : array.separator, place[k] / array.file[k]);
  }
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
  ZarrSource(const Grid& grid, const Node& node, Array array, const ArrayPart& part, Facts facts)
      : LayeredSource(grid, files_of(node, array, part), std::move(facts)),
        node_(node),
        array_(std::move(array)),
        part_(part),
        from_(array_.shape.size()),
        to_(array_.shape.size(), 1),
        first_slice_(part.lattice[2] >= 0 ? int(part.first[std::size_t(part.lattice[2])]) : 0) {
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
    if (z >= 0)
      part_.first[std::size_t(z)] = first_slice_ + begin, part_.end[std::size_t(z)] = first_slice_ + stop;
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
    if (array_.n5) read_sizes(chunk, offset, bytes);
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

  /// Of N5: a number that is 0, the number of axes, the sizes, which may end where the array does.
  void read_sizes(const Sizes& chunk, std::uint64_t& offset, std::uint64_t& bytes) {
    std::vector<std::byte> head(4 + 4 * chunk.size());
    file_->read(0, head);
    const BinaryFields fields(head, true);
    if (fields.at<std::uint32_t>(0) != chunk.size()) fail("have other axes than the array");
    array_.chunk_bytes = array_.type->bytes();
    for (std::size_t k = chunk.size(), at = 4; k-- > 0; at += 4) {
      const std::int64_t size = fields.at<std::uint32_t>(at), most = array_.chunk[k];
      if (size > most || size < std::min(most, array_.shape[k] - chunk[k]))
        fail("are not of the size that the metadata say");
      from_[k] = std::int64_t(array_.chunk_bytes / array_.type->bytes());
      array_.chunk_bytes *= std::uint64_t(size);
    }
    offset = head.size();
    bytes -= head.size();
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
  int first_slice_;  ///< of the array, along the lattice's z
  std::optional<InputFile> file_;  ///< that was read last
  Sizes held_;                     ///< the chunk that `values_` are of
  std::vector<std::byte> packed_, values_;
};

/// What "omero" says of a channel. A window that spans all that the values may be was nobody's choice.
ChannelNotes channel_in(const Json& json) {
  ChannelNotes notes{.name = text_in(json, "label")};
  notes.colour = hex_colour(text_in(json, "color"));
  notes.hidden = json.contains("active") && json["active"] == false;
  const Json window = json.value("window", Json::object());
  const auto number = [&](const char* key) {
    return window.contains(key) && window[key].is_number() ? window[key].get<double>() : std::nan("");
  };
  const glm::dvec2 shown(number("start"), number("end"));
  const bool all = shown.x == number("min") && shown.y == number("max");
  if (shown.x < shown.y && std::isfinite(shown.y - shown.x) && !all) notes.window = shown;
  return notes;
}

/// By what OME-Zarr says of an image and its level.
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
  const auto own = image.value("/metadata/ringsplat"_json_pointer, Json());
  if (own.is_object()) return describe_lattice(own, meaning);
  meaning.notes.world = World::microscope;
  meaning.notes.labels |= group.ome.contains("image-label");
  for (const auto& channel : group.ome.value("/omero/channels"_json_pointer, Json::array()))
    meaning.notes.of_channels.push_back(channel_in(channel));
  use_micrometres(meaning);
}

std::filesystem::path folder_of(const Node& image, const std::string& level) {
  const auto path = std::filesystem::path(level).lexically_normal();
  if (path.is_absolute() || path.string().starts_with(".."))
    image.fail("its level '{}' leads out of the store", excerpt(level));
  return std::filesystem::weakly_canonical(image.folder / path);
}

/// The only image or array in a group.
Node only_one(const Node& group) {
  std::vector<std::string> found;
  std::optional<Node> last;
  for (const auto& entry : std::filesystem::directory_iterator(group.folder)) {
    auto node = entry.is_directory() ? node_at(entry.path()) : std::nullopt;
    if (!node || (!node->is_array && !node->is_image())) continue;
    found.push_back(entry.path().filename().string());
    last = std::move(node);
  }
  if (found.size() == 1) return *last;
  std::ranges::sort(found);
  refuse(group.folder, "name the folder of an array or an image", "the group holds {}",
         found.empty() ? "none" : "several: " + comma_list(found));
}

struct Level {
  Node node;
  Array array;
  DatasetMeaning meaning;
  std::size_t number = 1, of = 1;   ///< among an image's, from the finest
  std::optional<Grid> finest = {};  ///< whose voxels a part of the image is given in
};

/// Settles what the axes mean.
Grid lattice_in(DatasetMeaning& meaning, const std::string& where) {
  settle_roles(meaning, where, "name them by _ARRAY_DIMENSIONS or dimension_names, such as t, c, z, y, x");
  return lattice_of(meaning, where);
}

/// The voxels of a level that hold a part of the finest one.
VoxelBox box_in_level(const VoxelBox& box, const glm::ivec3& finest, const glm::ivec3& level) {
  VoxelBox scaled;
  for (int k = 0; k < 3; ++k) {
    scaled.first[k] = int(std::int64_t(box.first[k]) * level[k] / finest[k]);
    scaled.end[k] = int((std::int64_t(box.end[k]) * level[k] + finest[k] - 1) / finest[k]);
  }
  return scaled;
}

Level described_array(Node node) {
  Level level{node, array_of(node), {}};
  describe_axes(node, level.array.shape, level.meaning);
  if (node.n5) describe_steps(node.json, level.meaning);
  return level;
}

/// Of an image the level in the folder `wanted`, or if that is the image the finest of which the part that is
/// read takes no more memory than there may be, else the coarsest. Nothing where the image has no level
/// there.
std::optional<Level> find_level(const Node& group, const Json& image, const std::filesystem::path& wanted,
                                const VolumeChoice& choice) {
  const double most = choice.memory.value_or(machine_memory_bytes() / slice_sets);
  double part = 1, finer = 0;
  std::optional<Grid> finest;
  const auto levels = list_in(image, "datasets");
  const bool any = wanted == group.folder;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const auto name = levels[k].at("path").get<std::string>();
    const auto folder = folder_of(group, name);
    if (!any && wanted != folder) continue;
    const auto node = node_at(folder);
    if (!node || !node->is_array) group.fail("its level '{}' leads to no array", excerpt(name));
    auto level = described_array(*node);
    level.number = k + 1, level.of = levels.size();
    describe(group, image, levels[k], level.meaning);
    if (choice.crop && !finest) {
      auto meaning = level.meaning;
      finest = lattice_in(meaning, group.folder.string());
      const glm::dvec3 parts = glm::dvec3(choice.crop(*finest).dims()) / glm::dvec3(finest->dims);
      part = parts.x * parts.y * parts.z;
    }
    level.finest = finest;
    double bytes = part * double(size_of(level.array.type->type));
    for (const auto& axis : level.meaning.axes) bytes *= axis.role == Role::space ? axis.size : 1;
    if (any && bytes > most && level.number < level.of) {
      finer = bytes;
      continue;
    }
    constexpr double gib = 1 << 30;
    if (finer > 0)
      log_line_once(LogLevel::info,
                    fmt::format("{}: level {} of {} is shown: the next finer one would take {:.3g} GiB, and "
                                "--memory allows {:.3g}",
                                group.folder.string(), level.number, level.of, finer / gib, most / gib));
    return level;
  }
  return {};
}

/// The array at a path, or a level of the image there, and what its axes mean: by the image in a group above
/// of which it is a level, else by their names.
Level find_array(const std::filesystem::path& path, const VolumeChoice& choice) {
  Node node = *node_at(std::filesystem::canonical(path));
  if (!node.is_array && !node.is_image()) node = only_one(node);
  constexpr int most_above = 3;
  auto above = node.folder;
  for (int k = 0; k <= most_above; ++k, above = above.parent_path()) {
    const auto group = node_at(above);
    if (!group || !group->is_image()) continue;
    for (const auto& image : group->ome["multiscales"])
      if (auto level = find_level(*group, image, node.folder, choice)) return *level;
  }
  return described_array(node);
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
  auto [node, array, meaning, level, levels, finest] = find_array(path, choice);
  meaning.notes.labels |= array.type->code == "b1";
  Grid grid = lattice_in(meaning, where);
  auto part = choose_part(meaning, array.type->type, choice, where);
  grid.type = array.type->type;
  if (meaning.notes.world == World::microscope && !meaning.direction) {
    grid.direction = microscope_axes * grid.direction;
    grid.origin = microscope_axes * grid.origin;
  }
  if (choice.crop) {
    const Grid& whole = finest.value_or(grid);
    const VoxelBox box = box_in_level(choice.crop(whole), whole.dims, grid.dims);
    grid = clipped_grid(grid, box);
    for (int k = 0; k < 3; ++k)
      if (const int axis = part.lattice[std::size_t(k)]; axis >= 0) {
        part.first[std::size_t(axis)] += box.first[k];
        part.end[std::size_t(axis)] = part.first[std::size_t(axis)] + box.dims()[k];
      }
  }
  const Grid read = interleaved_grid(grid, part.components, where);
  require_chunks(node, read.bytes());
  Facts facts{{"encoding", node.n5 ? "N5" : "Zarr"}};
  if (levels > 1) facts.push_back({"level", fmt::format("{} of {}", level, levels)});
  auto source = std::make_unique<ZarrSource>(read, node, array, part, std::move(facts));
  return with_notes(channel_source(std::move(source), grid, part.components, part.channel), meaning.notes);
} catch (const Json::exception& error) {
  refuse(path, "copy or write the store again", "its metadata cannot be read: {}", error.what());
}

}  // namespace ringsplat::detail
