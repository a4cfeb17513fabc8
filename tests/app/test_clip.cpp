// --clip: what people type, and the program itself, in one process and on ranks.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "app/workshop.hpp"
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

struct Files : Workshop {
  std::string picture = *this / "x.exr", alone = *this / "alone.exr";
  Files()
      : Workshop("jack", "40x36x44",
                 {"--size", "96x80", "--tf", "grey", "--azimuth", "30", "--elevation", "20"}) {}
  /// Draws alone and on ranks.
  void check_same_on(int ranks, const Words& layout, const Words& more) const {
    render("alone.exr", more);
    render("x.exr", joined(layout, more), ranks);
    CHECK(same_pictures(picture, alone));
  }
};

const Words boxed{"--clip", "5:31,3:36,7:40"};

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
  CHECK(says(refusal(":,:,0:122mm"), "it is 120 long there"));
  CHECK(says(refusal(":,:,1e300:"), "the z part, '1e300:', does not lie"));
  CHECK(says(refusal("1.5:2,:,:"), "no whole number"));
  CHECK(says(refusal(":,9:9,:"), "the y part, '9:9', has no voxel"));
  CHECK(says(refusal(":,20:10,:"), "FIRST must be less than END"));
  CHECK(says(refusal("0.3:0.7mm,:,:"), "a voxel counts when its centre lies between"));
}

TEST_CASE("--clip draws the same bits on ranks, in a ring and in a mesh, with both engines", "[mpi]") {
  const Files files;
  const std::vector<std::pair<Words, Words>> cases{
      {{"--engine", "splats"}, {"--topology", "mesh", "--mesh", "2x1", "--renderers", "1"}},
      {{"--engine", "sheets"}, {"--gps", "2", "--renderers", "1"}}};
  for (const auto& [engine, layout] : cases) {
    INFO(engine.back());
    files.check_same_on(3, layout, joined(boxed, engine));
    files.render("x.exr", engine);
    CHECK(run_program({"compare", files.picture, files.alone, "--fail-above", "1"}).code == 1);
  }
}

TEST_CASE("a picture with --clip is its method's and near the field's truth of the same box") {
  const Files files;
  const std::string truth = files / "truth.exr";
  for (const std::string engine : {"splats", "sheets"}) {
    files.render("x.exr", joined(boxed, {"--engine", engine}));
    for (const auto& [kind, bound] : {std::pair{"method", "0.6"}, {"field", "9"}}) {
      Words reference = files.words("truth.exr", joined(boxed, {"--engine", engine, "--truth", kind}));
      reference[0] = "reference";
      INFO(engine << ' ' << kind);
      succeeded(run_program(reference));
      const Ended compared = run_program({"compare", files.picture, truth, "--fail-above", bound});
      INFO(compared.out);
      CHECK(compared.code == 0);
    }
  }
}

TEST_CASE("--clip-plane draws the same bits on ranks, in a ring and in a mesh", "[mpi]") {
  const Files files;
  const std::vector<std::pair<std::string, Words>> cases{
      {"orthographic", {"--topology", "mesh", "--mesh", "2x1", "--renderers", "1"}},
      {"perspective", {"--roles", "colocated"}}};
  for (const auto& [projection, layout] : cases) {
    INFO(projection);
    files.check_same_on(3, layout,
                        {"--clip-plane", "0.4,1,-0.3,-2:-1,0.5,0.2,-9", "--projection", projection});
  }
  CHECK(says(files.render("x.exr", {"--clip-plane", "1,0,0,500"}).err,
             "clip planes leave nothing of the volume"));
}

TEST_CASE("a volume is cut open by a slice, which lies over what is left of it") {
  const Workshop shop("jack", "40x36x44", {"--size", "96x80", "--azimuth", "30"});
  const auto function = [&](const std::string& name, double opacity) {
    write_text(shop / name, fmt::format(R"([{{"RGBPoints": [0, 0, 0, 0, 255, 1, 1, 1],)"
                                        R"( "Points": [0, {0}, 0.5, 0, 255, 1, 0.5, 0]}}])",
                                        opacity));
    return Words{"--tf", shop / name};
  };
  const Words light = function("light.json", 0), opaque = function("opaque.json", 1);
  const auto picture = [&](const Words& colours, const Words& more) {
    shop.render("x.exr", joined(colours, more));
    return read_image(shop / "x.exr").image;
  };
  // The volume's middle is 1.5 voxels above slice 20. From above what lies below that is left.
  for (const auto& [elevation, left] : {std::pair{"20", "0,0,-1,1.5"}, {"-20", "0,0,1,-1.5"}}) {
    const Words from{"--elevation", elevation};
    const Image cut = picture(light, joined(from, {"--cut", "z=20"})),
                behind = picture(light, joined(from, {"--clip-plane", left})),
                slice = picture(opaque,
                                joined(from, {"--mode", "mip", "--clip-plane", "0,0,1,-1.501:0,0,-1,1.499"}));
    std::size_t over = 0, beside = 0;
    for (std::size_t k = 0; k < cut.rgba.size(); ++k) {
      const bool is_slice = slice.rgba[k | 3] == 1;
      over += is_slice;
      beside += !is_slice && behind.rgba[k | 3] > 0;
      REQUIRE(cut.rgba[k] == Approx(is_slice ? slice.rgba[k] : behind.rgba[k]).margin(1e-6));
    }
    CHECK(over > 3000);
    CHECK(beside > 100);
  }
}

TEST_CASE("a cut through a surface of one colour shows values in grey") {
  TemporaryFolder folder;
  const std::string volume = folder / "ramp.npy", picture = folder / "x.exr";
  std::string values;
  for (int k = 0; k < 24 * 24 * 24; ++k) values += char(8 * (k / 24 % 24));
  write_text(volume, files::npy("|u1", "(24, 24, 24)") + values);
  succeeded(run_program({"render", volume, "-o", picture, "--view", "right", "--size", "48", "--mode",
                         "surface", "--isovalue", "60", "--cut", "x=12"}));
  const Image cut = read_image(picture).image;
  const std::size_t row = std::size_t{24} * 48;
  CHECK(cut.rgba[4 * (row + 8) + 3] == 1);
  CHECK(cut.rgba[4 * (row + 40)] > cut.rgba[4 * (row + 8)] + 0.2F);
}

TEST_CASE("a cut has the same bits on ranks, near the field's truth", "[mpi]") {
  const Files files;
  const Words layouts[] = {{"--topology", "mesh", "--mesh", "2x1", "--renderers", "1"},
                           {"--roles", "colocated"}};
  for (const std::string projection : {"orthographic", "perspective"}) {
    const Words more{"--cut", "plane:1,0.4,-0.7,2", "--clip-plane", "0,1,0,-9", "--projection", projection};
    INFO(projection);
    files.check_same_on(3, layouts[projection == "perspective"], more);
    Words reference = files.words("truth.exr", more);
    reference[0] = "reference";
    succeeded(run_program(reference));
    succeeded(run_program({"compare", files.picture, files / "truth.exr", "--fail-above", "1"}));
  }
}

TEST_CASE("a slice of labels has their colours and no others") {
  TemporaryFolder folder;
  const std::string volume = folder / "labels.npy", picture = folder / "x.exr";
  std::string labels;
  for (int k = 0; k < 32 * 32 * 32; ++k) {
    const int x = k % 32, y = k / 32 % 32;
    labels += char(x < 6 || y < 6 || (x > 13 && x < 18) ? 0 : x < 16 ? 2 : 7);
  }
  write_text(volume, files::npy("|u1", "(32, 32, 32)") + labels);
  succeeded(run_program({"render", volume, "-o", picture, "--slice", "z=7", "--size", "100"}));
  std::set<std::array<float, 4>> colours;
  const auto& rgba = read_image(picture).image.rgba;
  for (std::size_t k = 0; k < rgba.size(); k += 4)
    colours.insert({rgba[k], rgba[k + 1], rgba[k + 2], rgba[k + 3]});
  CHECK(colours.size() == 3);
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
}

TEST_CASE("info --clip tells what is in the part") {
  const Files files;
  const Ended ended =
      succeeded(run_program({"info", files.volume(), "--clip", "15:25,10:20,0:40mm", "--json"}));
  const json part = json::parse(ended.out);
  CHECK(part["dims"] == json::array({10, 10, 40}));
  CHECK(part["clip"] == json::array({{15, 25}, {10, 20}, {0, 40}}));
  CHECK(part["finite"] == 4000);
  const json whole = json::parse(run_program({"info", files.volume(), "--json"}).out);
  CHECK_FALSE(whole.contains("clip"));
  CHECK(part["slice_memory_of_a_gp"] == whole["slice_memory_of_a_gp"]);
  std::uint64_t counted = 0;
  for (const std::uint64_t count : part["histogram"]["counts"]) counted += count;
  CHECK(counted == 4000);
  CHECK(says(run_program({"info", files.volume(), "--clip", ":,10:20,"}).out,
             "clip       0:40,10:20,0:44 of 40 x 36 x 44"));
  const Ended predicted = succeeded(run_program(
      {"info", files.volume(), "--clip", "3:37,9:20,11:40", "--ranks", "3", "--size", "64", "--json"}));
  CHECK(json::parse(predicted.out)["prediction"]["visible_voxels"] < 34 * 11 * 29 + 1);
}

TEST_CASE("a budget knows the clip box", "[mpi]") {
  const Files files;
  files.render("x.exr", joined(boxed, {"--max-error", "30", "--error", "field", "--error-pixels", "200"}));
}
