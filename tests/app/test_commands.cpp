// The program as people use it, on one process and on ranks.
#include <nlohmann/json.hpp>
#include <regex>

#include "app/workshop.hpp"
#include "formats/files.hpp"
#include "images/image_io.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app_test;
using nlohmann::json;

namespace {

struct Shell : Workshop {
  Shell() : Workshop("shell", "24x20x16", {"--size", "96x64", "--region", "32"}, {"--spacing", "1x1.5x1"}) {}
};

Ended must(const Words& words, int ranks = 0) { return succeeded(run_program(words, ranks)); }

double opaque_part(const Image& image) {
  double sum = 0;
  for (std::size_t at = 3; at < image.rgba.size(); at += 4) sum += image.rgba[at];
  return sum / double(image.rgba.size() / 4);
}

}  // namespace

TEST_CASE("help and version go to stdout", "[mpi]") {
  const Shell w;
  CHECK_THAT(must({"--version"}).out, Catch::Matchers::Contains("ringsplat "));
  const std::string help = must({"render", "--help"}).out;
  for (const char* part : {"--gps", "--tf", "--orbit", "512x512", "Examples:", "ringsplat render"})
    CHECK_THAT(help, Catch::Matchers::Contains(part));
  CHECK_THAT(must({"--help"}).out, Catch::Matchers::Contains("Exit codes"));
  CHECK(lines_with(must({"--help"}, 3).out, "Exit codes").size() == 1);
  CHECK_THAT(must({"info", "--presets"}).out, Catch::Matchers::Contains("mr-soft"));
  CHECK_THAT(must({"synth", "--list"}).out, Catch::Matchers::Contains("shell"));
}

TEST_CASE("render writes a picture with something in it and says so", "[mpi]") {
  const Shell w;
  const Ended ended = w.render("x.exr");
  CHECK(ended.err.empty());
  CHECK_THAT(ended.out, Catch::Matchers::Contains("x.exr") && Catch::Matchers::Contains("visible voxels") &&
                            Catch::Matchers::Contains("blocks"));
  const StoredImage picture = read_image(w / "x.exr");
  CHECK(picture.image.width == 96);
  CHECK(picture.image.height == 64);
  CHECK(opaque_part(picture.image) > 0.05);
  CHECK(opaque_part(picture.image) < 0.9);
  const json settings = json::parse(picture.settings);
  CHECK(settings.at("size") == json{96, 64});
  CHECK(settings.at("volume") == "volume.nrrd");
}

TEST_CASE("ranks, placement and transport do not change a bit", "[mpi]") {
  const Shell w;
  w.render("one.exr", {"--azimuth", "30"});
  const std::string one = read_text(w / "one.exr");
  const auto same = [&](const std::vector<std::string>& more, int ranks) {
    w.render("other.exr", joined({"--azimuth", "30"}, more), ranks);
    const bool same_bytes = read_text(w / "other.exr") == one;
    CHECK(same_bytes);
  };
  same({"--gps", "5", "--renderers", "3"}, 0);
  same({"--roles", "colocated", "--gps", "2", "--renderers", "2"}, 0);
  same({"--transport", "mpi"}, 0);
  same({}, 1);
  same({"--gps", "2"}, 3);
  same({"--roles", "colocated", "--look-ahead", "3", "--send-ahead", "4"}, 5);
  same({"--bundle", "5", "--gps", "2"}, 3);
  same({"--bundle", "1000", "--gps", "3", "--renderers", "2"}, 0);
}

TEST_CASE("equal pictures are equal files, on any ranks and however they are divided", "[mpi]") {
  const Shell w;
  for (const std::string name : {"x.png", "x.exr"}) {
    std::string one;
    for (const int ranks : {0, 3}) {
      const std::string region = std::to_string(16 + 8 * ranks);
      must({"render", w.volume(), "-o", w / name, "--size", "96x64", "--region", region}, ranks);
      if (ranks == 0) one = read_text(w / name);
      INFO(name << " on " << ranks << " ranks");
      const bool same = read_text(w / name) == one;
      CHECK(same);
    }
  }
}

TEST_CASE("an orbit makes numbered frames and a summary", "[mpi]") {
  const Shell w;
  const Ended ended = w.render(
      "turn.png", {"--orbit", "3", "--quality", "paper", "--gps", "2", "--stats", w / "turn.json"}, 3);
  for (const char* name : {"turn-0000.png", "turn-0001.png", "turn-0002.png"}) CHECK(fs::exists(w / name));
  CHECK_FALSE(fs::exists(w / "turn.png"));
  // Frames overlap, so a frame takes longer than the time from one to the next.
  CHECK(lines_with(ended.out, "s after the one before").size() == 2);
  const auto summary = lines_with(ended.out, "3 frames, median");
  REQUIRE(summary.size() == 1);
  CHECK_THAT(summary[0], Catch::Matchers::Contains("s from start to end, one every "));
  const json stats = json::parse(read_text(w / "turn.json"));
  REQUIRE(stats.size() == 3);
  double periods = 0;
  for (const json& frame : stats) periods += frame.at("period").get<double>();
  const double every = std::stod(summary[0].substr(summary[0].find("every ") + 6));
  CHECK(every == Approx(periods / 3).margin(6e-5));
  for (std::size_t k = 0; k < 3; ++k) {
    const json& s = stats[k];
    CHECK(s.at("settings").at("camera").at("azimuth").get<double>() == Approx(120.0 * double(k)));
    const json& t = s.at("total");
    CHECK(t.at("splats_sent").get<std::uint64_t>() > 0);
    CHECK(t.at("splats_sent").get<std::uint64_t>() ==
          t.at("splats_drawn").get<std::uint64_t>() + t.at("splats_clipped").get<std::uint64_t>());
    std::uint64_t predicted = 0;
    for (const auto& bytes : s.at("memory").at("predicted_slice_bytes"))
      predicted += bytes.get<std::uint64_t>();
    CHECK(predicted == t.at("slice_memory").get<std::uint64_t>());
  }
}

TEST_CASE("an orbit's files and lines are those of one process, in order", "[mpi]") {
  const Shell w;
  const auto frame = [&](int k) { return w / ("turn-000" + std::to_string(k) + ".png"); };
  w.render("turn.png", {"--orbit", "9"});
  std::vector<std::string> alone;
  for (int k = 0; k < 9; ++k) alone.push_back(read_text(frame(k)));
  const Ended ended = w.render(
      "turn.png", {"--orbit", "9", "--gps", "2", "--stats", w / "turn.json", "--frames-in-flight", "4"}, 3);
  const json stats = json::parse(read_text(w / "turn.json"));
  const auto lines = lines_with(ended.out, "visible voxels");
  REQUIRE(lines.size() == 9);
  REQUIRE(stats.size() == 9);
  for (int k = 0; k < 9; ++k) {
    const auto at = std::size_t(k);
    CHECK_THAT(lines[at], Catch::Matchers::StartsWith(frame(k)));
    CHECK(stats[at].at("file") == frame(k));
    const bool same_bytes = read_text(frame(k)) == alone[at];
    CHECK(same_bytes);
  }
}

TEST_CASE("only the slice sets that the views traverse are kept") {
  const Shell w;
  const auto kept = [&](const Words& more) {
    w.render("x.png", joined(more, {"--stats", w / "s.json"}));
    return json::parse(read_text(w / "s.json")).at(0).at("memory").at("kept_axes").get<std::string>();
  };
  CHECK(kept({"--elevation", "90"}) == "z");
  CHECK(kept({"--azimuth", "90"}) == "x");
  CHECK(kept({"--orbit", "4"}) == "xy");
}

TEST_CASE("a path renders its lines", "[mpi]") {
  const Shell w;
  write_text(w / "path.csv", "0 0\n90 0\n");
  w.render("walk.exr", {"--path", w / "path.csv"});
  w.render("side.exr", {"--azimuth", "90", "--fit", "sphere"});
  CHECK(read_image(w / "walk-0001.exr").image == read_image(w / "side.exr").image);
}

TEST_CASE("the transfer function used can be written and read back", "[mpi]") {
  const Shell w;
  w.render("a.exr", {"--tf-out", w / "tf.json"});
  w.render("b.exr", {"--tf", w / "tf.json"});
  CHECK(read_image(w / "a.exr").image == read_image(w / "b.exr").image);
}

TEST_CASE("a configuration file gives options and the command line overrides them", "[mpi]") {
  const Shell w;
  write_text(w / "run.toml",
             "gps = 2\nrenderers = 2\nzoom = 2.0\nlight = [0.0, 0.0, 1.0]\nno-opacity-correction = true\n");
  w.render("config.exr", {"--config", w / "run.toml", "--zoom", "1.5", "--stats", w / "s.json"});
  const json stats = json::parse(read_text(w / "s.json"))[0];
  CHECK(stats.at("layout").at("gps") == 2);
  CHECK(stats.at("settings").at("camera").at("zoom") == 1.5);
  CHECK(stats.at("settings").at("light") == json{0.0, 0.0, 1.0});
  CHECK(stats.at("settings").at("opacity_correction") == false);
}

TEST_CASE("a picture with nothing in it is the background, takes no payload and says why", "[mpi]") {
  const Shell w;
  const auto opaque_between = [&](int from, int to) {
    const std::string middle = std::to_string((from + to) / 2), low = std::to_string(from),
                      high = std::to_string(to);
    write_text(w / "tf.json", R"([{"Name": "some", "RGBPoints": [0, 1, 1, 1, 400, 1, 1, 1], "Points": [)" +
                                  low + ", 0, 0.5, 0, " + middle + ", 1, 0.5, 0, " + high + ", 0, 0.5, 0]}]");
  };
  const auto check_empty = [&](const std::vector<std::string>& more, const char* why, int ranks) {
    const Ended ended = w.render("x.exr", more, ranks);
    INFO(ended.err);
    CHECK(lines_with(ended.err, "the picture is empty").size() == 1);
    CHECK_THAT(ended.err, Catch::Matchers::Contains(why) && Catch::Matchers::Contains("hint:"));
    const Image image = read_image(w / "x.exr").image;
    REQUIRE(image.width == 96);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (int c = 0; c < 4; ++c)
          if (image.pixel(x, y)[c] != float(c == 0 || c == 3))
            FAIL("pixel " << x << ", " << y << " is not red");
    const json total = json::parse(read_text(w / "s.json")).at(0).at("total");
    for (const char* sum : {"payloads_sent", "payload_bytes_sent", "splats_sent", "tiles", "tile_bytes"})
      CHECK(total.at(sum) == 0);
  };
  const Words red{"--background", "1,0,0", "--stats", w / "s.json", "--quality", "paper"};
  const Words with_tf = joined(red, {"--tf", w / "tf.json"}),
              outside =
                  joined(red, {"--matrix", "1", "0", "0", "1e4", "0", "1", "0", "0", "0", "0", "1", "0"});
  for (const int ranks : {0, 3}) {
    opaque_between(300, 400);
    check_empty(with_tf, "is opaque from 300 to 400, but the volume's values run from 0 to 255", ranks);
    opaque_between(120, 122);
    check_empty(with_tf, "is opaque from 120 to 122, and no voxel has such a value", ranks);
    check_empty(outside, "no visible voxel lies in it", ranks);
  }
}

TEST_CASE("compare tells equal pictures from different ones", "[mpi]") {
  const Shell w;
  w.render("a.png");
  w.render("b.png", {"--azimuth", "5"});
  const Ended equal = run_program({"compare", w / "a.png", w / "a.png", "--fail-above", "0"});
  CHECK(equal.code == 0);
  const Ended differ = run_program(
      {"compare", w / "a.png", w / "b.png", "--fail-above", "0.5", "--json", "--diff", w / "d.png"});
  CHECK(differ.code == 1);
  const json j = json::parse(differ.out);
  CHECK(j.at("failed") == true);
  CHECK(j.at("rmse").get<double>() > 0.5);
  CHECK(j.at("channels").size() == 4);
  for (const auto& figures : j.at("channels"))
    for (const char* figure : {"rmse", "psnr", "largest", "mean", "over_1", "over_2"})
      CHECK(figures.at(figure).is_number());
  CHECK(j.at("over_1") == j.at("fraction_over"));
  CHECK(j.at("over_2") <= j.at("over_1"));
  CHECK(read_image(w / "d.png").image.width == 96);
  CHECK(run_program({"compare", w / "a.png", w / "b.png", "--fail-above", "200"}).code == 0);
  const std::string before = read_text(w / "a.png");
  CHECK(run_program({"compare", w / "a.png", w / "b.png", "--diff", w / "a.png"}).code == 2);
  const bool untouched = read_text(w / "a.png") == before;
  CHECK(untouched);
  // The same picture in two encodings differs only by rounding to 8 bits.
  w.render("a.exr");
  CHECK(run_program({"compare", w / "a.exr", w / "a.png", "--fail-above", "1.5"}).code == 0);
  CHECK(run_program({"compare", w / "a.exr", w / "a.png", "--fail-above", "200"}, 2).code == 0);
  // An .exr has the scaled difference with its sign, and alpha 1.
  w.render("b.exr", {"--azimuth", "5"});
  must({"compare", w / "a.exr", w / "b.exr", "--diff", w / "d.exr", "--diff-scale", "2"});
  const Image a = read_image(w / "a.exr").image, b = read_image(w / "b.exr").image,
              d = read_image(w / "d.exr").image;
  for (std::size_t at = 0; at < d.rgba.size(); ++at)
    if (d.rgba[at] != (at % 4 == 3 ? 1.0F : float(2 * (double(a.rgba[at]) - double(b.rgba[at])))))
      FAIL_CHECK("value " << at);
  must({"render", w.volume(), "-o", w / "small.png", "--size", "32"});
  CHECK(run_program({"compare", w / "a.png", w / "small.png"}).code == 2);
}

TEST_CASE("info knows the volume") {
  const Shell w;
  const json j = json::parse(must({"info", w.volume(), "--json", "--gps", "3"}).out);
  CHECK(j.at("dims") == json{24, 20, 16});
  CHECK(j.at("type") == "uint8");
  CHECK(j.at("spacing") == json{1.0, 1.5, 1.0});
  CHECK(j.at("not_finite") == 0);
  std::uint64_t counted = 0;
  for (const auto& count : j.at("histogram").at("counts")) counted += count.get<std::uint64_t>();
  CHECK(counted == 24 * 20 * 16);
  // 8 of 24, 7 of 20 and 6 of 16 slices; a voxel has 1 byte of value and 2 of normal.
  const json& memory = j.at("slice_memory_of_a_gp").at(0);
  CHECK(memory.at("all_axes_unlit") == 8 * 20 * 16 + 7 * 24 * 16 + 6 * 24 * 20);
  CHECK(memory.at("all_axes_lit") == 3 * (8 * 20 * 16 + 7 * 24 * 16 + 6 * 24 * 20));
  // In bundles of five: 10 of 24 slices, 10 of 20 and 6 of 16.
  const json bundles = json::parse(must({"info", w.volume(), "--json", "--gps", "3", "--bundle", "5"}).out);
  CHECK(bundles.at("slice_memory_of_a_gp").at(0).at("all_axes_unlit") ==
        10 * 20 * 16 + 10 * 24 * 16 + 6 * 24 * 20);
  CHECK_THAT(must({"info", w.volume(), "--bundle", "5"}).out, Catch::Matchers::Contains("in bundles of 5"));
  const std::string text = must({"info", w.volume()}).out;
  for (const char* part : {"24 x 20 x 16", "histogram", "--gps", "range"})
    CHECK_THAT(text, Catch::Matchers::Contains(part));
}

TEST_CASE("the presets come as JSON too") {
  const Ended ended = succeeded(run_program({"info", "--presets", "--json"}));
  const json presets = json::parse(ended.out);
  REQUIRE(presets.size() > 5);
  for (const json& preset : presets) {
    CHECK_FALSE(preset.at("name").get<std::string>().empty());
    CHECK_FALSE(preset.at("description").get<std::string>().empty());
  }
  CHECK(lines_with(run_program({"info", "--presets"}).out, presets.front().at("name").get<std::string>())
            .size() == 1);
}

TEST_CASE("info and render warn once of what is wrong with a volume", "[mpi]") {
  const TemporaryFolder folder;
  fs::create_directory(folder / "series");
  files::Dicom slice;
  slice.pixels.assign(std::size_t(slice.columns * slice.rows) * 2, '\1');
  for (const int z : {0, 1, 2, 5, 6}) {
    slice.number = z;
    slice.position = "0\\0\\" + std::to_string(z);
    write_text(folder / ("series/" + std::to_string(z) + ".dcm"), slice.bytes());
  }
  const std::string series = folder / "series";
  for (const Words& words :
       {Words{"info", series},
        {"info", series, "--ranks", "2"},
        {"render", series, "-o", folder / "x.png", "--size", "32", "--error", "method", "--tf", "grey"}}) {
    const Ended ended = succeeded(run_program(words));
    INFO(ended.err);
    CHECK(lines_with(ended.err, "2 slices are missing").size() == 1);
  }
}

TEST_CASE("info lists a folder's DICOM series, and --series takes one", "[mpi]") {
  const TemporaryFolder folder;
  files::Dicom other;
  other.series = "1.2.3.400.50.6";
  for (const char* name : {"a", "b"}) fs::create_directory(folder / name);
  files::write_dicom_series(folder / "a");
  other.pixels = files::samples<short>().substr(0, 40);
  write_text(folder / "b/one.dcm", other.bytes());
  const Ended all = run_program({"info", folder / ""});
  INFO(all.out + all.err);
  CHECK(all.code == 0);
  CHECK(lines_with(all.out, "  3 slices CT, UID 1.2.3.4.5").size() == 1);
  CHECK(lines_with(all.out, "  1 slice CT, UID ...400.50.6").size() == 1);
  const Ended one = run_program({"info", folder / "", "--series", "400.50.6", "--json"});
  CHECK(nlohmann::json::parse(one.out).at("dims") == nlohmann::json{5, 4, 1});
  CHECK(nlohmann::json::parse(one.out).at("series").size() == 2);
}

TEST_CASE("zero is never printed with a minus sign", "[mpi]") {
  const TemporaryFolder folder;
  fs::create_directory(folder / "series");
  files::Dicom slice;
  slice.orientation = "-1\\-0\\0\\0\\-1\\-0";
  files::write_dicom_series(folder / "series", slice);
  const auto has_minus_zero = [](const std::string& text) {
    return std::regex_search(text, std::regex(R"((^|[\s(\[,:])[-]0(\.0*)?([\s)\],]|$))"));
  };
  REQUIRE(has_minus_zero("(1 -0 0)"));
  REQUIRE(has_minus_zero("[-0.0,1]"));
  const Ended text = succeeded(run_program({"info", folder / "series"})),
              json_text = run_program({"info", folder / "series", "--json"});
  REQUIRE(json_text.code == 0);
  INFO(text.out << json_text.out);
  CHECK_FALSE(has_minus_zero(text.out));
  CHECK_FALSE(has_minus_zero(json_text.out));
  const Shell w;
  w.render("x.png", {"--elevation", "-0.0", "--stats", w / "s.json"});
  CHECK_FALSE(has_minus_zero(read_text(w / "s.json")));
}

TEST_CASE("a file name that is not UTF-8 goes into statistics and pictures with its bytes replaced") {
  const Shell w;
  const std::string volume = w / "sh\xff.nrrd";
  fs::copy_file(w.volume(), volume);
  must({"render", volume, "-o", w / "x.png", "--size", "32", "--stats", w / "s.json"});
  CHECK_THAT(json::parse(read_text(w / "s.json")).at(0).at("volume").get<std::string>(),
             Catch::Matchers::EndsWith("sh\xef\xbf\xbd.nrrd"));
  CHECK(json::parse(read_image(w / "x.png").settings).at("volume") == "sh\xef\xbf\xbd.nrrd");
  CHECK(run_program({"info", volume, "--json"}).code == 0);
}

TEST_CASE("no run leaves a file that was not asked for", "[mpi]") {
  const Shell w;
  w.render("x.png", {"--stats", w / "s.json", "--tf-out", w / "t.json"}, 2);
  CHECK(files_in(w.path()) == 4);
}

TEST_CASE("a verbose run says what every rank is there for", "[mpi]") {
  const Shell w;
  const Ended ended = w.render("x.png", {"--gps", "2", "--verbose"}, 3);
  for (const char* part :
       {"[rank 0]: debug: GP 0 keeps", "[rank 1]: debug: GP 1 keeps", "[rank 2]: debug: Renderer 0 is here"})
    CHECK_THAT(ended.err, Catch::Matchers::Contains(part));
}

TEST_CASE("a frame that cannot be written ends the run on all ranks", "[mpi]") {
  const Shell w;
  fs::create_directories(w / "turn-0001.png/in_the_way");
  for (const int ranks : {0, 3}) {
    const Ended ended =
        run_program({"render", w.volume(), "-o", w / "turn.png", "--orbit", "4", "--size", "32"}, ranks);
    INFO(ended.err);
    CHECK(ended.code == 3);
    REQUIRE(lines_with(ended.err, "error:").size() == 1);
    CHECK_THAT(lines_with(ended.err, "error:").front(), Catch::Matchers::Contains("turn-0001.png"));
    CHECK(ended.seconds < 30);
    fs::remove(w / "turn-0000.png");
    // The volume and the obstacle.
    CHECK(files_in(w.path()) == 2);
  }
}
