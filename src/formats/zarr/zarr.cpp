#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <utility>

#include "base/log.hpp"
#include "base/printable.hpp"
#include "base/process.hpp"
#include "base/srgb.hpp"
#include "base/text.hpp"
#include "formats/formats.hpp"
#include "formats/label_notes.hpp"
#include "formats/zarr/metadata.hpp"
#include "volume/forwarding_source.hpp"

namespace ringsplat::detail {
namespace {

using namespace zarr;
using Role = DatasetAxis::Role;

/// A GP may hold its slices along three axes.
constexpr int slice_sets = 3;

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
         found.empty() ? "none" : "several: " + joined(found));
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
  const double most = choice.memory.value_or(machine_memory_bytes() / slice_sets / choice.volumes);
  double part = 1, finer = 0;
  bool passes_one = choice.coarser;
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
    if (!finest) {
      auto meaning = level.meaning;
      finest = lattice_in(meaning, group.folder.string());
      if (choice.crop)
        part = double(clipped_grid(*finest, choice.crop(*finest)).voxels()) / double(finest->voxels());
    }
    level.finest = finest;
    double bytes = part * double(size_of(level.array.type->type));
    for (const auto& axis : level.meaning.axes) bytes *= axis.role == Role::space ? axis.size : 1;
    if (any && bytes > most && level.number < level.of) {
      finer = bytes;
      continue;
    }
    if (any && level.number < level.of && std::exchange(passes_one, false)) continue;
    constexpr double gib = 1 << 30;
    if (finer > 0 && !choice.coarser)
      log_info_once(
          "{}: level {}, 0 being the finest, is shown: the next takes {:.3g} GiB, --memory allows {:.3g}",
          group.folder.string(), k, finer / gib, most / gib);
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
  if (choice.crop) {
    const Grid whole = finest.value_or(grid);
    const VoxelBox wanted = choice.crop(whole), box = box_in_level(wanted, whole.dims, grid.dims);
    grid = clipped_grid(grid, box);
    finest = clipped_grid(whole, wanted);
    for (int k = 0; k < 3; ++k)
      if (const int axis = part.lattice[std::size_t(k)]; axis >= 0) {
        part.first[std::size_t(axis)] += box.first[k];
        part.end[std::size_t(axis)] = part.first[std::size_t(axis)] + box.dims()[k];
      }
  }
  meaning.notes.finest = finest;
  const Grid read = interleaved_grid(grid, part.components, where);
  require_chunks(node, read.bytes());
  Facts facts{{"encoding", node.n5 ? "N5" : "Zarr"}};
  if (levels > 1) facts.push_back({"level", fmt::format("{} of {}", level, levels)});
  auto source = array_source(read, node, array, part, std::move(facts));
  return with_notes(channel_source(std::move(source), grid, part.components, part.channel), meaning.notes);
} catch (const Json::exception& error) {
  refuse(path, "copy or write the store again", "its metadata cannot be read: {}", error.what());
}

std::map<double, LabelNotes> zarr_label_notes(const std::filesystem::path& folder) try {
  std::map<double, LabelNotes> notes;
  auto image = zarr::node_at(folder);
  if (image && image->is_array) image = zarr::node_at(folder.parent_path());
  if (!image) return notes;
  const auto said = image->ome.value("image-label", zarr::Json::object());
  for (const auto& entry : zarr::list_in(said, "colors"))
    if (const auto rgba = entry.value("rgba", std::vector<double>()); rgba.size() >= 3)
      notes[entry.at("label-value")].colour =
          glm::clamp(glm::dvec3(rgba[0], rgba[1], rgba[2]) / 255.0, 0.0, 1.0);
  for (const auto& entry : zarr::list_in(said, "properties"))
    for (const char* const key : {"class", "name"})  // OME leaves keys open; a name comes before a class
      if (const auto name = zarr::text_in(entry, key); !name.empty())
        notes[entry.at("label-value")].name = printable(name);
  return notes;
} catch (const zarr::Json::exception&) {
  return {};
}

}  // namespace ringsplat::detail
