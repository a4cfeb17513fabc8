// --clip: what people type, and the program itself, in one process and on ranks.
#include <nlohmann/json.hpp>

#include "app/succeeded.hpp"
#include "formats/npy.hpp"
#include "images/image_io.hpp"
#include "options/option_values.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat;
using namespace ringsplat::app_test;
using nlohmann::json;

namespace {

Grid lattice() {
  Grid grid;
  grid.dims = {100, 80, 60};
  grid.spacing = {0.5, 0.75, 2};
  return grid;
}

VoxelBox box_of(const std::string& text) {
  return app::clip_box(app::parse_clip(text, "--clip"), lattice()).value();
}
std::string refusal(const std::string& text) {
  return message_of([&] { static_cast<void>(box_of(text)); });
}

struct Files {
  TemporaryFolder folder;
  std::string volume = folder / "jack.nrrd", picture = folder / "x.exr";
  Files() { REQUIRE(run_program({"synth", "jack", "-o", volume, "--dims", "40x36x44"}).code == 0); }
  std::vector<std::string> render(std::vector<std::string> more) const {
    more.insert(more.begin(), {"render", volume, "-o", picture, "--size", "96x80", "--tf", "grey",
                               "--azimuth", "30", "--elevation", "20", "--clip", "5:31,3:36,7:40"});
    return more;
  }
  /// Draws alone and on three layouts of ranks; returns the file of the one picture.
  std::string same_on_ranks(const std::vector<std::string>& more) const {
    std::string alone = folder / "alone.exr";
    REQUIRE(run_program(render(more)).code == 0);
    fs::rename(picture, alone);
    const auto same_on = [&](int ranks, std::vector<std::string> layout) {
      layout.insert(layout.end(), more.begin(), more.end());
      succeeded(run_program(render(layout), ranks));
      CHECK(run_program({"compare", picture, alone, "--fail-above", "0"}).code == 0);
    };
    same_on(5, {"--gps", "3", "--renderers", "2"});
    same_on(3, {"--roles", "colocated"});
    same_on(6, {"--topology", "mesh", "--mesh", "2x2", "--renderers", "2"});
    return alone;
  }
};

}  // namespace

TEST_CASE("a clip box is typed in voxels, with what is left out meaning up to the face") {
  CHECK(box_of("10:20,30:40,50:60") == VoxelBox{{10, 30, 50}, {20, 40, 60}});
  CHECK(box_of(":,:,:") == VoxelBox{{0, 0, 0}, {100, 80, 60}});
  CHECK(box_of(",10:20,") == VoxelBox{{0, 10, 0}, {100, 20, 60}});
  CHECK(box_of(" 5: , :7 ,8:9") == VoxelBox{{5, 0, 8}, {100, 7, 9}});
  CHECK(box_of("0:100,0:80,0:60") == VoxelBox{{0, 0, 0}, {100, 80, 60}});
}

TEST_CASE("with mm a clip box has the voxels whose centres lie between, part by part or in all") {
  CHECK(box_of("10:20mm,30:40,:") == VoxelBox{{20, 30, 0}, {40, 40, 60}});
  CHECK(box_of("10:20,30:45,0:120mm") == VoxelBox{{20, 40, 0}, {40, 60, 60}});
  CHECK(box_of("10:20,30:,:100 mm") == VoxelBox{{20, 40, 0}, {40, 80, 50}});
  // Centres lie at 0.25, 0.75, 1.25 …
  CHECK(box_of("0.3:1.2mm,:,:") == VoxelBox{{1, 0, 0}, {2, 80, 60}});
  CHECK(box_of("0.2:1.3mm,:,:") == VoxelBox{{0, 0, 0}, {3, 80, 60}});
  Grid long_axes = lattice();
  long_axes.direction[0] = {2, 0, 0};
  CHECK(app::clip_box(app::parse_clip("10:20mm,:,:", "--clip"), long_axes)->end.x == 20);
}

TEST_CASE("the part of a clip box that is wrong is named, and what is possible") {
  CHECK(says(refusal("10:20"), "--clip '10:20' has 1 part instead of three"));
  CHECK(says(refusal("1:2,3:4,5:6,7:8"), "4 parts"));
  CHECK(says(refusal("1:2,34,5:6"), "the y part, '34', is no range"));
  CHECK(says(refusal("1:2,3:4,5:b"), "the z part, '5:b', is no range"));
  CHECK(says(refusal("mm,:,:"), "the x part, 'mm', is no range"));
  CHECK(says(refusal("0:inf,:,:"), "the x part, '0:inf', is no range"));
  CHECK(says(refusal("1 2:3,:,:"), "the x part, '1 2:3', is no range"));
  CHECK(says(refusal("1:2,-3:4,:"), "the y part, '-3:4', does not lie within the volume"));
  CHECK(says(refusal("1:101,:,:"), "it has voxels 0:100 there"));
  CHECK(says(refusal(":,:,0:122mm"), "it is 120 mm long there"));
  CHECK(says(refusal(":,:,1e300:"), "the z part, '1e300:', does not lie"));
  CHECK(says(refusal("1.5:2,:,:"), "no whole number"));
  CHECK(says(refusal(":,9:9,:"), "the y part, '9:9', has no voxel"));
  CHECK(says(refusal(":,20:10,:"), "FIRST must be less than END"));
  CHECK(says(refusal("0.3:0.7mm,:,:"), "a voxel counts when its centre lies between"));
}

TEST_CASE("--clip draws the same bits on ranks, in a ring and in a mesh, with both engines", "[mpi]") {
  const Files files;
  for (const std::string engine : {"splats", "sheets"}) {
    INFO(engine);
    const std::string clipped = files.same_on_ranks({"--engine", engine});
    REQUIRE(run_program({"render", files.volume, "-o", files.picture, "--size", "96x80", "--tf", "grey",
                         "--azimuth", "30", "--elevation", "20", "--engine", engine})
                .code == 0);
    CHECK(run_program({"compare", files.picture, clipped, "--fail-above", "1"}).code == 1);
  }
}

TEST_CASE("a picture with --clip is its method's and near the field's truth of the same box") {
  const Files files;
  for (const std::string engine : {"splats", "sheets"}) {
    const std::string truth = files.folder / "truth.exr";
    REQUIRE(run_program(files.render({"--engine", engine})).code == 0);
    for (const auto& [kind, bound] : {std::pair{"method", "0.6"}, {"field", "9"}}) {
      std::vector<std::string> reference = files.render({"--engine", engine, "--truth", kind});
      reference[0] = "reference";
      reference[3] = truth;
      const Ended ended = run_program(reference);
      INFO(engine << ' ' << kind << ended.err);
      REQUIRE(ended.code == 0);
      const Ended compared = run_program({"compare", files.picture, truth, "--fail-above", bound});
      INFO(compared.out);
      CHECK(compared.code == 0);
    }
  }
}

TEST_CASE("--clip-plane draws the same bits on ranks, in a ring and in a mesh", "[mpi]") {
  const Files files;
  for (const char* const projection : {"orthographic", "perspective"}) {
    INFO(projection);
    files.same_on_ranks({"--clip-plane", "0.4,1,-0.3,-2:-1,0.5,0.2,-9", "--projection", projection});
  }
}

TEST_CASE("an oblique slice has the interpolated values of its plane") {
  TemporaryFolder folder;
  // 2 x + 3 y - z is linear: interpolation is exact.
  const std::string volume = folder / "plane.npy", picture = folder / "slice.exr";
  std::string values;
  constexpr int side = 24;
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const auto value = float(2 * x + 3 * y - z);
        values.append(reinterpret_cast<const char*>(&value), sizeof value);
      }
  write_text(volume, files::npy("<f4", "(24, 24, 24)") + values);
  succeeded(
      run_program({"render", volume, "-o", picture, "--slice", "plane:1,1,1,4", "--values", "--size", "32"}));
  const auto image = read_image(picture).image;
  // The middle of the picture is 4 / sqrt(3) voxels along each axis from the volume's middle.
  const double there = 11.5 + 4 / std::sqrt(3.0);
  double sum = 0;
  for (const std::size_t at : {15 * 32 + 15, 15 * 32 + 16, 16 * 32 + 15, 16 * 32 + 16}) {
    CHECK(image.rgba[4 * at + 3] == 1);
    sum += image.rgba[4 * at];
  }
  CHECK(sum / 4 == Approx(4 * there).margin(0.01));
  CHECK(says(run_program({"render", volume, "-o", picture, "--slice", "plane:1,1,0"}).err,
             "--slice plane: '1,1,0' is no plane"));
  CHECK(says(run_program({"render", volume, "-o", picture, "--clip-plane", "1,0,0,500"}).err,
             "clip planes leave nothing of the volume"));
  CHECK(says(
      run_program({"render", volume, "-o", picture, "--clip-plane", "1,0,0,0", "--quality", "paper"}).err,
      "--clip-plane has no effect on splats"));
}

TEST_CASE("info --clip tells what is in the part") {
  const Files files;
  const Ended ended =
      succeeded(run_program({"info", files.volume, "--clip", "15:25,10:20,0:40mm", "--json"}));
  const json part = json::parse(ended.out);
  CHECK(part["dims"] == json::array({10, 10, 40}));
  CHECK(part["clip"] == json::array({{15, 25}, {10, 20}, {0, 40}}));
  CHECK(part["finite"] == 4000);
  const json whole = json::parse(run_program({"info", files.volume, "--json"}).out);
  CHECK_FALSE(whole.contains("clip"));
  CHECK(part["slice_memory_of_a_gp"] == whole["slice_memory_of_a_gp"]);
  std::uint64_t counted = 0;
  for (const std::uint64_t count : part["histogram"]["counts"]) counted += count;
  CHECK(counted == 4000);
  CHECK(says(run_program({"info", files.volume, "--clip", ":,10:20,"}).out,
             "clip       0:40,10:20,0:44 of 40 x 36 x 44"));
  const Ended predicted = succeeded(run_program(
      {"info", files.volume, "--clip", "3:37,9:20,11:40", "--ranks", "3", "--size", "64", "--json"}));
  CHECK(json::parse(predicted.out)["prediction"]["visible_voxels"] < 34 * 11 * 29 + 1);
}

TEST_CASE("a clip box that is none of the volume's is refused before a voxel is read", "[mpi]") {
  const Files files;
  for (const int ranks : {0, 3}) {
    const Ended ended =
        run_program({"render", files.volume, "-o", files.picture, "--clip", "0:40,0:37,0:44"}, ranks);
    CHECK(ended.code == 2);
    CHECK(says(ended.err, "the y part, '0:37', does not lie within the volume"));
    CHECK(says(ended.err, "it has voxels 0:36 there"));
    CHECK_FALSE(fs::exists(files.picture));
  }
  for (const char* command : {"info", "reference"}) {
    std::vector<std::string> arguments{command, files.volume, "--clip", "7:7,,"};
    if (command == std::string("reference")) arguments.insert(arguments.end(), {"-o", files.picture});
    const Ended ended = run_program(arguments);
    CHECK(ended.code == 2);
    CHECK(says(ended.err, "the x part, '7:7', has no voxel"));
  }
}

TEST_CASE("a budget knows the clip box", "[mpi]") {
  const Files files;
  const Ended budget =
      run_program(files.render({"--max-error", "30", "--error", "field", "--error-pixels", "200"}));
  INFO(budget.err);
  CHECK(budget.code == 0);
}
