// From where a volume is seen, and how large, when options leave it open.
#include <nlohmann/json.hpp>

#include "app/workshop.hpp"
#include "options/option_tables.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app_test;
using nlohmann::json;

namespace {

Grid box(int x, int y, int z, const glm::dvec3& spacing = glm::dvec3(1)) {
  Grid grid;
  grid.dims = {x, y, z};
  grid.spacing = spacing;
  return grid;
}

struct Direction {
  double azimuth, elevation;
  bool operator==(const Direction&) const = default;
};

Direction first_view(app::RenderOptions o, const Grid& grid, World world = World::lattice) {
  const std::string note = app::complete_view(o, grid, {.world = world});
  const Direction seen{o.frame.shown.camera.azimuth, o.frame.shown.camera.elevation};
  CHECK(note.empty() == (seen == Direction{0, 0} || seen == Direction{30, 20} || o.direction_chosen));
  return seen;
}

Direction from(app::Side side, World world = World::lattice) {
  app::RenderOptions o;
  o.side = side;
  o.direction_chosen = true;
  return first_view(o, box(256, 256, 8), world);
}

constexpr Direction front{0, 0}, top{0, 90}, right{90, 0}, corner{30, 20};

/// A flat volume of no patient, as .raw files are.
struct Files {
  TemporaryFolder folder;
  std::string flat = folder / "flat_40x36x10_uint8.raw", x = folder / "x.exr", y = folder / "y.exr";
  Files() { succeeded(run_program({"synth", "jack", "-o", folder / "flat.raw", "--dims", "40x36x10"})); }
  Ended render(const std::string& output, const Words& more, int ranks = 0) const {
    const Words words{"render", flat, "-o", output, "--size", "96x64", "--tf", "grey"};
    return succeeded(run_program(joined(words, more), ranks));
  }
  json camera(const Words& more) const {
    return json::parse(render(x, joined(more, {"--stats", "-"})).out).at(0).at("settings").at("camera");
  }
};

}  // namespace

TEST_CASE("a flat lattice is seen from its broad side, in world units") {
  CHECK(first_view({}, box(256, 256, 32)) == top);
  CHECK(first_view({}, box(32, 256, 256)) == right);
  CHECK(first_view({}, box(256, 32, 256)) == front);
  CHECK(first_view({}, box(256, 256, 85)) == top);
  CHECK(first_view({}, box(256, 85, 256)) == front);
  CHECK(first_view({}, box(64, 64, 64, {1, 1, 0.2})) == top);
  CHECK(first_view({}, box(20, 300, 20)) == right);
}

TEST_CASE("a solid that is no patient is seen from above and the right, unless some option says from where") {
  CHECK(first_view({}, box(256, 256, 256)) == corner);
  CHECK(first_view({}, box(256, 256, 86)) == corner);
  CHECK(first_view({}, box(256, 86, 256)) == corner);
  CHECK(first_view({}, box(256, 256, 32, {1, 1, 8})) == corner);
  CHECK(first_view({}, box(300, 20, 20)) == corner);
  CHECK(first_view({}, box(256, 256, 256), World::microscope) == corner);
  CHECK(first_view({}, box(256, 256, 256), World::patient) == front);
  app::RenderOptions chosen;
  chosen.direction_chosen = true;
  CHECK(first_view(chosen, box(256, 256, 256)) == front);
}

TEST_CASE("a patient is turned for a few slices only, as radiologists look at them") {
  CHECK(first_view({}, box(256, 256, 60), World::patient) == front);
  CHECK(first_view({}, box(256, 256, 16), World::patient) == Direction{0, -90});
  CHECK(first_view({}, box(1, 256, 256), World::patient) == Direction{90, 0});
  CHECK(first_view({}, box(256, 1, 256), World::patient) == front);
}

TEST_CASE("a microscope's thin stack and a chosen direction are not turned") {
  const Grid flat = box(256, 256, 16);
  CHECK(first_view({}, flat, World::microscope) == front);
  app::RenderOptions chosen;
  chosen.direction_chosen = true;
  chosen.frame.shown.camera.azimuth = 30;
  CHECK(first_view(chosen, flat) == Direction{30, 0});
}

TEST_CASE("a lattice whose axes are swapped in the world is flat where the world sees it so") {
  Grid grid = box(256, 256, 16);
  grid.direction = glm::dmat3(glm::dvec3(1, 0, 0), glm::dvec3(0, 0, -1), glm::dvec3(0, 1, 0));
  CHECK(first_view({}, grid) == front);
  grid.direction = glm::dmat3(glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0));
  CHECK(first_view({}, grid) == right);
}

TEST_CASE("--view has its angles; left is the patient's where there is one") {
  using enum app::Side;
  CHECK(from(app::Side::front) == ::front);
  CHECK(from(back) == Direction{180, 0});
  CHECK(from(app::Side::right) == ::right);
  CHECK(from(left) == Direction{-90, 0});
  CHECK(from(left, World::patient) == Direction{90, 0});
  CHECK(from(app::Side::right, World::patient) == Direction{-90, 0});
  CHECK(from(app::Side::top) == ::top);
  CHECK(from(bottom) == Direction{0, -90});
}

TEST_CASE("the program turns a flat volume, says so in a line, and draws it alike on ranks", "[mpi]") {
  const Files files;
  const Ended plain = files.render(files.x, {});
  CHECK(lines_with(plain.err, "the volume is flat").size() == 1);
  const Ended asked = files.render(files.y, {"--view", "top"}, 3);
  CHECK(lines_with(asked.err, "the volume is flat").empty());
  CHECK(same_pictures(files.x, files.y));
  files.render(files.y, {}, 3);
  CHECK(same_pictures(files.x, files.y));
  files.render(files.y, {"--view", "front"});
  CHECK_FALSE(same_pictures(files.x, files.y));
}

TEST_CASE("single views fit the box, turning ones the sphere, unless --fit says otherwise", "[mpi]") {
  const Files files;
  write_text(files.folder / "path", "10 20\n");
  CHECK(files.camera({}).value("fit", "") == "box");
  CHECK(files.camera({"--fit", "box"}).value("fit", "") == "box");
  CHECK(files.camera({"--projection", "perspective", "--quality", "best"}).value("fit", "") == "box");
  CHECK_FALSE(files.camera({"--fit", "sphere"}).contains("fit"));
  CHECK_FALSE(files.camera({"--orbit", "2"}).contains("fit"));
  CHECK_FALSE(files.camera({"--path", files.folder / "path"}).contains("fit"));
  CHECK(files.camera({"--orbit", "2", "--fit", "box"}).value("fit", "") == "box");
  CHECK_FALSE(
      files.camera({"--projection", "perspective", "--quality", "best", "--distance", "5"}).contains("fit"));
}

TEST_CASE("the reference sees what the picture sees", "[mpi]") {
  const Files files;
  files.render(files.x, {"--shading", "none"});
  REQUIRE(run_program({"reference", files.flat, "-o", files.y, "--size", "96x64", "--tf", "grey", "--truth",
                       "method", "--shading", "none"})
              .code == 0);
  const Ended compared = run_program({"compare", files.x, files.y, "--fail-above", "0.5"});
  INFO(compared.out);
  CHECK(compared.code == 0);
}
