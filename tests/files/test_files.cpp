// Files that other libraries wrote, against the voxels that were put into them. tests/files/make.py writes
// both.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "ringsplat/formats/open.hpp"
#include "support/catch.hpp"
#include "support/memory_source.hpp"
#include "support/scenes.hpp"

using namespace ringsplat;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

/// What a writer's cases.py says of one file.
struct Case {
  fs::path folder;
  json wanted;
  std::string name;

  std::string file() const { return (folder / wanted.at("file").get<std::string>()).string(); }
  VolumeChoice choice() const {
    VolumeChoice choice;
    if (wanted.contains("frame")) choice.frame = wanted["frame"].get<int>();
    choice.channel = wanted.value("channel", "");
    choice.series = wanted.value("series", "");
    return choice;
  }
  std::vector<std::byte> voxels() const {
    const fs::path path = folder / wanted.at("voxels").get<std::string>();
    std::vector<std::byte> bytes(fs::file_size(path));
    std::ifstream(path, std::ios::binary)
        .read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()));
    return bytes;
  }
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  if (!fs::exists(RINGSPLAT_OTHERS_FILES)) return cases;
  for (const auto& entry : fs::recursive_directory_iterator(RINGSPLAT_OTHERS_FILES))
    if (entry.path().extension() == ".json" && entry.path().filename() != "zarr.json" &&
        entry.path().filename() != "attributes.json")
      cases.push_back({entry.path().parent_path(), json::parse(std::ifstream(entry.path())),
                       entry.path().stem().string()});
  std::sort(cases.begin(), cases.end(), [](const Case& a, const Case& b) { return a.name < b.name; });
  return cases;
}

glm::dvec3 vector_of(const json& numbers) { return {numbers[0], numbers[1], numbers[2]}; }

/// Files hold many lattices in float32.
bool near(const glm::dvec3& a, const glm::dvec3& b) {
  return glm::distance(a, b) <= 1e-5 * std::max(1.0, glm::length(b));
}

const char* name_of(World world) {
  return world == World::patient ? "patient" : world == World::microscope ? "microscope" : "lattice";
}

void check_grid(const Grid& grid, const json& wanted) {
  CHECK(to_string(grid.type) == wanted.at("type").get<std::string>());
  CHECK(glm::dvec3(grid.dims) == vector_of(wanted.at("dims")));
  CAPTURE(grid.spacing.x, grid.spacing.y, grid.spacing.z, grid.origin.x, grid.origin.y, grid.origin.z);
  if (wanted.contains("spacing")) CHECK(near(grid.spacing, vector_of(wanted["spacing"])));
  if (wanted.contains("origin")) CHECK(near(grid.origin, vector_of(wanted["origin"])));
  if (!wanted.contains("direction")) return;
  for (int axis = 0; axis < 3; ++axis) {
    CAPTURE(axis, grid.direction[axis].x, grid.direction[axis].y, grid.direction[axis].z);
    CHECK(near(grid.direction[axis], vector_of(wanted["direction"][std::size_t(axis)])));
  }
}

void check_notes(const VolumeNotes& notes, const json& wanted) {
  if (wanted.contains("unit")) CHECK(notes.unit == wanted["unit"].get<std::string>());
  if (wanted.contains("world")) CHECK(name_of(notes.world) == wanted["world"].get<std::string>());
  if (wanted.contains("frames")) CHECK(notes.frames == wanted["frames"].get<int>());
  if (wanted.contains("of_channels")) {
    json found;
    for (const ChannelNotes& channel : notes.of_channels) {
      const auto& [name, colour, window, hidden] = channel;
      found.push_back({name, nullptr, nullptr, hidden});
      if (colour) found.back()[1] = {colour->x, colour->y, colour->z};
      if (window) found.back()[2] = {window->x, window->y};
    }
    CHECK(found == wanted["of_channels"]);
  }
  if (wanted.contains("channels")) CHECK(notes.channels == wanted["channels"].get<int>());
}

std::vector<std::byte> read_all(VolumeSource& source) {
  std::vector<std::byte> bytes(source.grid().bytes());
  source.read_slices(0, source.grid().dims.z, bytes);
  return bytes;
}

FrameSpec small_picture(const std::vector<std::byte>& voxels, ScalarType type) {
  ValueRange range;
  range.add(type, voxels);
  FrameSpec spec{.how = Splats{}};
  spec.shown.width = spec.shown.height = 24;
  spec.shown.transfer_function = test::ramp(range.low, range.high, 0.5);
  return spec;
}

}  // namespace

TEST_CASE("files of other libraries have their voxels, places and units") {
  const auto cases = all_cases();
  if (cases.empty()) {
    WARN("skipped: no files in " RINGSPLAT_OTHERS_FILES);
    return;
  }
  for (const Case& one : cases) DYNAMIC_SECTION(one.name) {
      const auto source = open_volume(one.file(), {}, one.choice());
      check_grid(source->grid(), one.wanted);
      check_notes(source->notes(), one.wanted);
      const auto voxels = one.voxels();
      REQUIRE(source->grid().bytes() == voxels.size());
      CHECK(read_all(*source) == voxels);
    }
}

TEST_CASE("a picture of another library's file has the bits of one from memory") {
  for (const Case& one : all_cases()) DYNAMIC_SECTION(one.name) {
      const auto source = open_volume(one.file(), {}, one.choice());
      const auto voxels = one.voxels();
      REQUIRE(source->grid().bytes() == voxels.size());
      const auto memory = memory_source(source->grid(), voxels);
      const FrameSpec spec = small_picture(voxels, source->grid().type);
      const auto from_file = test::render_loopback(*source, spec, 3, 2);
      CHECK(from_file.image.rgba == test::render_loopback(*memory, spec, 3, 2).image.rgba);
    }
}
