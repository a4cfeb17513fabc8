// Roles chosen by a forecast, through the program's options.
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/succeeded.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app_test;
using nlohmann::json;

namespace {

std::string make_volume(const TemporaryFolder& folder) {
  const std::string volume = folder / "shell.nrrd";
  REQUIRE(run_program({"synth", "shell", "-o", volume, "--dims", "32x30x28"}).code == 0);
  return volume;
}

std::vector<std::string> render(const std::string& volume, const std::string& picture,
                                const std::vector<std::string>& more) {
  std::vector<std::string> all{"render", volume,     "-o", picture,     "--size",
                               "96x64",  "--region", "32", "--quality", "paper"};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

}  // namespace

TEST_CASE("chosen roles are said, and give the bits of any others", "[mpi]") {
  const TemporaryFolder folder;
  const std::string volume = make_volume(folder);
  REQUIRE(run_program(render(volume, folder / "one.exr", {})).code == 0);
  const std::string one = read_text(folder / "one.exr");
  const auto check_choice = [&](const std::vector<std::string>& options, int ranks) {
    std::vector<std::string> more = options;
    more.insert(more.end(), {"--stats", folder / "stats.json"});
    const Ended ended = succeeded(run_program(render(volume, folder / "auto.exr", more), ranks));
    const bool same_bits = read_text(folder / "auto.exr") == one;
    CHECK(same_bits);
    const json layout = json::parse(read_text(folder / "stats.json")).at(0).at("layout");
    CHECK(layout.at("ranks") == ranks);
    CHECK(lines_with(ended.err, "info: measuring ").size() <= 1);
    const auto lines = lines_with(ended.err, "info: chose ");
    REQUIRE(lines.size() == 1);
    const int gps = layout.at("gps").get<int>(), renderers = layout.at("renderers").get<int>();
    const int idle = layout.at("idle").get<int>();
    CHECK((lines.front().find(std::to_string(idle) + " idle:") != std::string::npos) == (idle > 0));
    const std::string said = layout.at("roles") == "colocated"
                                 ? std::to_string(ranks - idle) + " colocated rank"
                                 : std::to_string(gps) + " GP" + (gps == 1 ? "" : "s") + " + " +
                                       std::to_string(renderers) + " Renderer";
    CHECK_THAT(lines.front(), Catch::Matchers::Contains("chose " + said));
    return layout;
  };
  for (const int ranks : {1, 2, 3, 5}) check_choice({"--gps", "auto"}, ranks);
  CHECK(check_choice({"--renderers", "auto", "--roles", "dedicated"}, 3).at("roles") == "dedicated");
  const json given = check_choice({"--gps", "auto", "--renderers", "2"}, 5);
  CHECK(given.at("renderers") == 2);
  CHECK(given.at("idle") == 0);
}

TEST_CASE("what this machine's cores do is measured once and kept", "[mpi]") {
  const TemporaryFolder folder;
  const std::string volume = make_volume(folder);
  setenv("XDG_CACHE_HOME", (folder / "cache").c_str(), 1);
  const fs::path kept = folder / "cache/ringsplat";
  const auto chosen = [&](const std::string& method) {
    const Ended ended = run_program({"render", volume, "-o", folder / "x.exr", "--size", "64", "--engine",
                                     method, "--gps", "auto", "--renderers", "2"},
                                    2);
    INFO(ended.err);
    CHECK(ended.code == 0);
    const auto lines = lines_with(ended.err, "info: chose ");
    REQUIRE(lines.size() == 1);
    CHECK_THAT(lines.front(), Catch::Matchers::Contains("chose 2 colocated ranks"));
    return ended.err;
  };
  const auto measured = [](const std::string& err) { return lines_with(err, "info: measuring ").size(); };
  CHECK(measured(chosen("splats")) == 1);
  REQUIRE(files_in(kept) == 1);
  CHECK(measured(chosen("sheets")) == 0);
  CHECK(files_in(kept) == 1);
  const fs::path file = fs::directory_iterator(kept)->path();
  json wrong = json::parse(read_text(file));
  wrong["measured"][2] = -1;
  for (const std::string& damaged : {std::string("{"), wrong.dump()}) {
    write_text(file, damaged);
    const std::string err = chosen("sheets");
    CHECK(measured(err) == 1);
    CHECK(lines_with(err, "warning: the machine " + file.string()).size() == 1);
    CHECK(measured(chosen("sheets")) == 0);
  }
  unsetenv("XDG_CACHE_HOME");
}

TEST_CASE("roles that cannot be chosen are refused", "[mpi]") {
  const TemporaryFolder folder;
  const std::string volume = make_volume(folder);
  const auto refused = [&](const std::vector<std::string>& more, int ranks, const std::string& part) {
    const Ended ended = run_program(render(volume, folder / "x.exr", more), ranks);
    INFO(ended.err);
    CHECK(ended.code == 2);
    CHECK(lines_with(ended.err, "error:").size() == 1);
    CHECK_THAT(ended.err, Catch::Matchers::Contains(part));
  };
  refused({"--gps", "auto"}, 0, "mpirun -n N");
  refused({"--gps", "some"}, 0, "--gps cannot be 'some'");
  refused({"--gps", "auto", "--renderers", "7"}, 3, "3 ranks cannot be given such roles");
  refused({"--renderers", "auto", "--topology", "mesh", "--mesh", "2x1"}, 3, "has no effect in a mesh");
  CHECK_FALSE(fs::exists(folder / "x.exr"));
}

TEST_CASE("info predicts every layout for a number of ranks") {
  const TemporaryFolder folder;
  const std::string volume = make_volume(folder);
  const Ended ended = succeeded(run_program(
      {"info", volume, "--ranks", "6", "--size", "96", "--quality", "paper", "--json", "--cores", "6"}));
  const json prediction = json::parse(ended.out).at("prediction");
  CHECK(prediction.at("cores") == 6);
  CHECK(prediction.at("visible_voxels").get<double>() > 0);
  const json& layouts = prediction.at("layouts");
  // 5 + 1 … 1 + 5, six colocated of which six, three or one draw, and a mesh of 2x2 with two Renderers
  REQUIRE(layouts.size() == 9);
  double before = 0;
  for (const json& layout : layouts) {
    CHECK(layout.at("seconds").get<double>() >= before);
    before = layout.at("seconds").get<double>();
  }
  const std::string text = run_program({"info", volume, "--ranks", "6", "--size", "96", "--quality", "paper",
                                        "--azimuth", "30", "--tf", "grey"})
                               .out;
  for (const char* part : {"a frame on 6 ranks", "mesh of 2x2 + 2 Renderers", "6 colocated ranks", "best: "})
    CHECK_THAT(text, Catch::Matchers::Contains(part));
  for (const auto& wrong : std::vector<std::vector<std::string>>{{"--azimuth", "30"},
                                                                 {"--cores", "2"},
                                                                 {"--machine", "x.toml"},
                                                                 {"--quality", "paper"},
                                                                 {"--ranks", "0"},
                                                                 {"--ranks", "2", "--zoom", "0"}}) {
    std::vector<std::string> arguments{"info", volume};
    arguments.insert(arguments.end(), wrong.begin(), wrong.end());
    const Ended refused = run_program(arguments);
    INFO(wrong.front() << ": " << refused.err);
    CHECK(refused.code == 2);
    CHECK_THAT(refused.err, Catch::Matchers::Contains(wrong.size() > 2 ? "zoom" : "--ranks"));
  }
}

TEST_CASE("info predicts for a described machine what its file and the frame's counts say") {
  const TemporaryFolder folder;
  const std::string machine = folder / "machine.toml";
  write_text(machine, R"(name = "round numbers"
poll_interval = 1
[gp]
visible_voxel = 1e-3
transparent_voxel = 1e-4
slice = 0.5
frame = 2
[renderer]
splat = 1e-2
slice = 4
pixel = 1e-5
[platform]
kind = "backbone"
bandwidth = 1e15
latency = 0
)");
  const std::string volume = make_volume(folder);
  const Ended ended = succeeded(run_program({"info", volume, "--ranks", "2", "--size", "96", "--quality",
                                             "paper", "--tf", "grey", "--json", "--machine", machine}));
  const json all = json::parse(ended.out), prediction = all.at("prediction");
  CHECK(prediction.at("machine") == "round numbers");
  CHECK(prediction.at("cores") == 2);
  const double voxels = all.at("voxels"), visible = prediction.at("visible_voxels");
  const double slices = all.at("dims").at(1);  // seen from the front
  CHECK(visible > 0);
  CHECK(prediction.at("gp_seconds").get<double>() ==
        Approx(slices * 0.5 + visible * 1e-3 + (voxels - visible) * 1e-4));
  CHECK(prediction.at("gp_frame_seconds") == 2);
  // The rest are payloads, 4 s each: one for each slice with visible voxels.
  const double payloads = (prediction.at("renderer_seconds").get<double>() -
                           prediction.at("splats").get<double>() * 1e-2 - 96 * 96 * 1e-5) /
                          4;
  CHECK(payloads == Approx(std::round(payloads)));
  CHECK(payloads > slices / 2);
  CHECK(payloads <= slices);
  const Ended sheets = succeeded(run_program({"info", volume, "--ranks", "4", "--size", "96", "--quality",
                                              "best", "--tf", "grey", "--json", "--machine", machine}));
  const json of_sheets = json::parse(sheets.out).at("prediction");
  CHECK(of_sheets.at("layouts").size() ==
        6);  // 3 + 1 … 1 + 3, and four colocated ranks of which four, two or one draw
  CHECK(of_sheets.at("visible_voxels").get<double>() >= visible);  // whole blocks
  const Ended refused =
      run_program({"info", volume, "--ranks", "2", "--quality", "paper", "--machine", folder / "none.toml"});
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Catch::Matchers::Contains("none.toml"));
}

TEST_CASE("a forecast knows what a host's link takes to carry") {
  const TemporaryFolder folder;
  const std::string volume = make_volume(folder);
  const auto seconds = [&](const std::string& bandwidth, int gps, const std::string& roles) {
    write_text(folder / "machine.toml",
               "name = \"hosts of 8\"\npoll_interval = 1e-4\n[gp]\nvisible_voxel = 1e-8\n"
               "transparent_voxel = 1e-9\n[renderer]\nsplat = 1e-8\n[platform]\nkind = \"fat_tree\"\n"
               "latency = 1e-6\ncores = 8\nbandwidth = " +
                   bandwidth + "\n");
    const Ended ended =
        succeeded(run_program({"info", volume, "--quality", "paper", "--size", "96x64", "--ranks", "16",
                               "--machine", folder / "machine.toml", "--json"}));
    const json layouts = json::parse(ended.out).at("prediction").at("layouts");
    for (const json& layout : layouts)
      if (layout.at("topology") != "mesh" && layout.at("gps") == gps && layout.at("roles") == roles)
        return layout.at("seconds").get<double>();
    FAIL("no such layout");
    return 0.0;
  };
  // Half of what is sent stays on its host, or all of it goes from one to the other.
  CHECK(seconds("1e6", 16, "colocated") < 0.5 * seconds("1e6", 8, "dedicated"));
}
