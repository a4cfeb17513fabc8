// --frames: series of volumes, as files of a pattern and drawn one after another.
#include <bit>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "app/render_job.hpp"
#include "app/workshop.hpp"
#include "formats/npy.hpp"
#include "options/option_values.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace ringsplat::app_test;
using nlohmann::json;
using ringsplat::InputError;
using ringsplat::app::chosen_frames;
using ringsplat::app::files_of_pattern;
using ringsplat::app::parse_frames;

namespace {

/// A series whose volumes differ, of one grid; every second one is compressed, so that one rank decodes it.
struct Series {
  TemporaryFolder folder;
  std::string stats = folder / "stats.json";
  std::vector<std::string> shapes{"gaussians", "shell", "ball", "gaussians", "shell"};
  Series() {
    for (std::size_t k = 0; k < shapes.size(); ++k) make(file(int(k)), shapes[k], "24x20x22", k % 2 == 0);
    // A preset depends on its volume's histogram.
    const Ended ended = succeeded(run_program({"render", file(2), "-o", folder / "first.png", "--size", "16",
                                               "--tf", "mr-soft", "--tf-out", tf()}));
  }
  static void make(const std::string& name, const std::string& shape, const std::string& dims,
                   bool compressed) {
    std::vector<std::string> words{"synth", shape, "-o", name, "--dims", dims};
    if (!compressed) words.emplace_back("--no-compression");
    succeeded(run_program(words));
  }
  std::string tf() const { return folder / "tf.json"; }
  std::string file(int number) const { return folder / ("step_" + std::to_string(number + 8) + ".nrrd"); }
  std::string pattern() const { return folder / "step_*.nrrd"; }
  Words render(const std::string& frames, const Words& more = {}) const {
    return joined({"render", pattern(), "--frames", frames, "-o", folder / "x.png", "--size", "64x48", "--tf",
                   tf(), "--azimuth", "20"},
                  more);
  }
  bool has(const std::string& name) const { return fs::exists(folder / name); }
  /// True when a picture equals that of its volume by itself.
  bool same_as_alone(const std::string& name, int number, const Words& more = {},
                     const std::string& azimuth = "20") const {
    const std::string alone = folder / "alone.png";
    succeeded(run_program(joined(
        {"render", file(number), "-o", alone, "--size", "64x48", "--tf", tf(), "--azimuth", azimuth}, more)));
    return same_pictures(folder / name, alone);
  }
};

std::vector<std::string> names(const std::string& pattern) {
  std::vector<std::string> all;
  for (const auto& [number, file] : files_of_pattern(pattern))
    all.push_back(std::to_string(number) + " " + fs::path(file).filename().string());
  return all;
}

}  // namespace

TEST_CASE("a pattern's files come in natural order, or by the numbers in their names") {
  const TemporaryFolder folder;
  for (const char* name : {"s_2.raw", "s_10.raw", "s_1.raw", "s_01.raw", "other.raw", "s_x.raw", "t_0004.raw",
                           "t_0012.raw", "t_10000.raw", "t_5.raw"})
    write_text(folder / name, "x");
  using Names = std::vector<std::string>;
  CHECK(names(folder / "s_[0-9]*.raw") == Names{"0 s_01.raw", "1 s_1.raw", "2 s_2.raw", "3 s_10.raw"});
  CHECK(names(folder / "s_%d.raw") == Names{"1 s_1.raw", "2 s_2.raw", "10 s_10.raw"});
  CHECK(names(folder / "t_%04d.raw") == Names{"4 t_0004.raw", "12 t_0012.raw", "10000 t_10000.raw"});
  CHECK(files_of_pattern(folder / "t_%04d.raw:/field").front().second.ends_with("t_0004.raw:/field"));
  CHECK_THROWS_AS(files_of_pattern(folder / "u_*.raw"), InputError);
  CHECK_THROWS_AS(files_of_pattern(folder / "t_%s.raw"), InputError);
  CHECK_THROWS_AS(files_of_pattern(folder / "t_%04d_%d.raw"), InputError);
}

TEST_CASE("a range of frames goes from the first to before the last") {
  const std::vector<int> numbers{3, 4, 5, 6, 9};
  const auto chosen = [&](const std::string& text) {
    return chosen_frames(parse_frames(text, "--frames"), numbers, "it");
  };
  using Numbers = std::vector<int>;
  CHECK(chosen(":") == numbers);
  CHECK(chosen("all") == numbers);
  CHECK(chosen("4:6") == Numbers{4, 5});
  CHECK(chosen("5:") == Numbers{5, 6, 9});
  CHECK(chosen("3::3") == Numbers{3, 6, 9});
  CHECK(chosen("3:10:3") == Numbers{3, 6, 9});
  CHECK(chosen(":5") == Numbers{3, 4});
  CHECK_THAT(ringsplat::message_of([&] { chosen("4:9"); }), Catch::Matchers::Contains("there is no frame 7"));
  CHECK_THROWS_AS(chosen("10:"), InputError);
  CHECK_THROWS_AS(chosen("3:2000000000"), InputError);
  for (const char* text :
       {"", "3", "5:5", "5:2", "a:b", "1:2:0", "1:2:3:4", "-1:2", "1.5:2", "1:99999999999"}) {
    INFO(text);
    CHECK_THROWS_AS(parse_frames(text, "--frames"), InputError);
  }
}

TEST_CASE("the pictures of a series are those of its volumes by themselves, on any number of ranks",
          "[mpi]") {
  const Series series;
  for (const int ranks : {0, 4}) {
    INFO(ranks << " ranks");
    const Ended ended = succeeded(run_program(series.render("all", {"--stats", series.stats}), ranks));
    for (int k = 0; k < 5; ++k) CHECK(series.same_as_alone("x-000" + std::to_string(k) + ".png", k));
    const json stats = json::parse(read_text(series.stats));
    REQUIRE(stats.size() == 5);
    for (int k = 0; k < 5; ++k) {
      CHECK(stats[std::size_t(k)]["volume"] == series.file(k));
      CHECK(stats[std::size_t(k)]["frame"] == k);
    }
    CHECK(lines_with(ended.out, "step_12.nrrd: ").size() == 1);
    for (int k = 0; k < 5; ++k) fs::remove(series.folder / ("x-000" + std::to_string(k) + ".png"));
  }
}

TEST_CASE("reduced and unshaded volumes of a series are those of the volumes by themselves", "[mpi]") {
  const Series series;
  for (const Words& more :
       {Words{"--undersample", "2", "--prefilter"}, {"--clip", "2:20,3:15,4:18"}, {"--shading", "none"}}) {
    INFO(more.front());
    succeeded(run_program(series.render("1:3", joined({"--gps", "2"}, more)), 3));
    for (int k = 1; k < 3; ++k) CHECK(series.same_as_alone("x-000" + std::to_string(k) + ".png", k, more));
  }
}

TEST_CASE("pictures have the numbers that --frames counts by") {
  const Series series;
  auto words = series.render("9:12:2");
  words[1] = series.folder / "step_%d.nrrd";
  succeeded(run_program(words));
  CHECK(series.same_as_alone("x-0009.png", 1));
  CHECK(series.same_as_alone("x-0011.png", 3));
  CHECK_FALSE(series.has("x-0010.png"));
  CHECK(run_program(series.render("1:2")).code == 0);
  CHECK(series.same_as_alone("x-0001.png", 1));
}

TEST_CASE("the transfer function that is chosen for the first volume is kept for all", "[mpi]") {
  const Series series;
  auto words = series.render("0:2", {"--tf-out", series.folder / "auto.json"});
  *(std::find(words.begin(), words.end(), series.tf())) = "auto";
  const Ended ended = succeeded(run_program(words, 2));
  CHECK(lines_with(ended.out, "of the first").size() == 1);
  succeeded(run_program({"render", series.file(1), "-o", series.folder / "one.png", "--size", "64x48",
                         "--azimuth", "20", "--tf", series.folder / "auto.json"}));
  CHECK(same_pictures(series.folder / "x-0001.png", series.folder / "one.png"));
}

TEST_CASE("a volume of a series that cannot be read ends the run with 2 and its name, after those before it",
          "[mpi]") {
  for (const bool cut : {true, false}) {
    INFO((cut ? "cut" : "of another grid"));
    const Series series;
    if (cut)
      fs::resize_file(series.file(3), fs::file_size(series.file(3)) / 2);
    else
      Series::make(series.file(3), "shell", "24x20x23", true);
    const Ended ended = run_program(series.render("all", {"--stats", series.stats}), cut ? 3 : 0);
    INFO(ended.err);
    CHECK(ended.code == 2);
    CHECK(lines_with(ended.err, "step_11.nrrd").size() == 1);
    CHECK(series.same_as_alone("x-0002.png", 2));
    CHECK_FALSE(series.has("x-0003.png"));
    CHECK(json::parse(read_text(series.stats)).size() == 3);
  }
}

TEST_CASE("a volume of denormal numbers is the same wherever it comes in a series") {
  const TemporaryFolder folder;
  constexpr int side = 16;
  std::vector<float> voxels;
  // By their bits, as tests before this one may have left this thread without denormals. A unit is 1e-40.
  for (int k = 0; k < side * side * side; ++k)
    voxels.push_back(std::bit_cast<float>(std::uint32_t(71362 * (k % side + 2 * (k / side % side)))));
  for (const char* name : {"d_0_16x16x16_float32.raw", "d_1_16x16x16_float32.raw"})
    write_text(folder / name, {reinterpret_cast<const char*>(voxels.data()), voxels.size() * sizeof(float)});
  write_text(
      folder / "tf.json",
      R"([{"ColorSpace":"RGB","Name":"all","RGBPoints":[-1,1,1,1,1,1,1,1],"Points":[-1,0.3,0.5,0,1,0.3,0.5,0]}])");
  const auto render = [&](const std::string& output, const std::string& shading) {
    succeeded(run_program({"render", folder / "d_*.raw", "--frames", "all", "-o", folder / output, "--size",
                           "48", "--tf", folder / "tf.json", "--azimuth", "30", "--shading", shading,
                           "--quality", "paper"}));
  };
  const auto same = [&](const std::string& a, const std::string& b) {
    return same_pictures(folder / a, folder / b);
  };
  render("lit.png", "phong");
  render("plain.png", "none");
  CHECK(same("lit-0000.png", "lit-0001.png"));
  CHECK_FALSE(same("lit-0000.png", "plain-0000.png"));
}

TEST_CASE("one file's own frames are a series, as its volumes by themselves", "[mpi]") {
  const TemporaryFolder folder;
  constexpr int frames = 3, side = 12;
  std::string voxels;
  for (int k = 0; k < frames * side * side * side; ++k)
    voxels.push_back(char(k / (side * side * side) * 40 + 5 * (k % side)));
  write_text(folder / "film.npy", files::npy("|u1", "(3, 12, 12, 12)") + voxels);
  const Words look{"render", folder / "film.npy", "--size", "32",        "--tf",
                   "grey",   "--range",           "0:150",  "--azimuth", "30"};
  const auto render = [&](const Words& words, int ranks) {
    const Ended ended = succeeded(run_program(joined(look, words), ranks));
    return lines_with(ended.err, "time point").size();
  };
  CHECK(render({"-o", folder / "x.png", "--frames", "all"}, 3) == 0);
  CHECK(render({"-o", folder / "alone.png"}, 3) == 1);
  const Ended info = run_program({"info", folder / "film.npy", "--frame", "1"});
  CHECK_THAT(info.out, Catch::Matchers::Contains("time point 2 of 3, --frame N takes another, 0 to 2"));
  CHECK(info.err.empty());
  for (int k = 0; k < frames; ++k) {
    const std::string number = std::to_string(k);
    CHECK(render({"-o", folder / "alone.png", "--frame", number}, 0) == 0);
    CHECK(same_pictures(folder / ("x-000" + number + ".png"), folder / "alone.png"));
  }
  CHECK(run_program({"compare", folder / "x-0000.png", folder / "x-0002.png", "--fail-above", "1"}).code ==
        1);
}

TEST_CASE("a camera may move on with each volume of a series", "[mpi]") {
  const Series series;
  succeeded(run_program(series.render("0:3", {"--orbit", "3"}), 2));
  CHECK(series.same_as_alone("x-0001.png", 1, {"--fit", "sphere"}, "140"));
  check_refused(run_program(series.render("0:3", {"--orbit", "4"}), 2), "give --orbit 3");
}

TEST_CASE("what cannot be a series is refused with a way out", "[mpi]") {
  const Series series;
  const auto refused = [&](const Words& words, const std::string& why) {
    check_refused(run_program(words), why);
  };
  refused({"render", series.pattern(), "-o", series.folder / "y.png"}, "add --frames all");
  refused({"render", series.file(0), "--frames", "all", "-o", series.folder / "y.png"}, "holds one volume");
  refused(series.render("0:9"), "there is no frame 5");
  for (const char* name : {"x-0000.tif", "x-0001.tif"})
    write_text(series.folder / name, "not to be replaced");
  refused({"render", series.folder / "x-*.tif", "--frames", "all", "-o", series.folder / "x.tif"},
          "would replace");
  CHECK(read_text(series.folder / "x-0001.tif") == "not to be replaced");
  refused(series.render("all", {"--error", "method"}), "--error");
  refused(series.render("all", {"--frame", "0"}), "--frame");
}
