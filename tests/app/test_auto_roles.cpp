// Roles chosen by a forecast, through the program's options.
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/workshop.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app_test;
using nlohmann::json;

namespace {

struct Shell : Workshop {
  Shell() : Workshop("shell", "32x30x28", {"--size", "96x64", "--region", "32", "--quality", "paper"}) {}
  /// What is predicted of a frame on ranks.
  json predicted(const Words& more) const {
    const Ended ended = succeeded(run_program(joined({"info", volume(), "--json"}, more)));
    return json::parse(ended.out);
  }
};

}  // namespace

TEST_CASE("chosen roles are said, and give the bits of any others", "[mpi]") {
  const Shell w;
  w.render("one.exr");
  const std::string one = read_text(w / "one.exr");
  const auto check_choice = [&](const Words& options, int ranks) {
    const Ended ended = w.render("auto.exr", joined(options, {"--stats", w / "stats.json"}), ranks);
    const bool same_bits = read_text(w / "auto.exr") == one;
    CHECK(same_bits);
    const json layout = json::parse(read_text(w / "stats.json")).at(0).at("layout");
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
  for (const int ranks : {1, 3, 5}) check_choice({"--gps", "auto"}, ranks);
  CHECK(check_choice({"--renderers", "auto", "--roles", "dedicated"}, 3).at("roles") == "dedicated");
  const json given = check_choice({"--gps", "auto", "--renderers", "2"}, 5);
  CHECK(given.at("renderers") == 2);
  CHECK(given.at("idle") == 0);
}

TEST_CASE("what this machine's cores do is measured once and kept", "[mpi]") {
  const Shell w;
  setenv("XDG_CACHE_HOME", (w / "cache").c_str(), 1);
  const fs::path kept = w / "cache/ringsplat";
  const auto chosen = [&](const std::string& method) {
    const Ended ended = succeeded(run_program({"render", w.volume(), "-o", w / "x.exr", "--size", "64",
                                               "--engine", method, "--gps", "auto", "--renderers", "2"},
                                              2));
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

TEST_CASE("info predicts every layout for a number of ranks") {
  const Shell w;
  const json prediction =
      w.predicted({"--ranks", "6", "--size", "96", "--quality", "paper", "--cores", "6"}).at("prediction");
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
  const std::string text = run_program({"info", w.volume(), "--ranks", "6", "--size", "96", "--quality",
                                        "paper", "--azimuth", "30", "--tf", "grey"})
                               .out;
  for (const char* part : {"a frame on 6 ranks", "mesh of 2x2 + 2 Renderers", "6 colocated ranks", "best: "})
    CHECK_THAT(text, Catch::Matchers::Contains(part));
  check_refused(run_program({"info", w.volume(), "--ranks", "2", "--zoom", "0"}), "zoom");
}

TEST_CASE("info predicts for a described machine what its file and the frame's counts say") {
  const Shell w;
  const std::string machine = w / "machine.toml";
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
  const json all = w.predicted(
      {"--ranks", "2", "--size", "96", "--quality", "paper", "--tf", "grey", "--machine", machine});
  const json prediction = all.at("prediction");
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
  const json of_sheets =
      w.predicted({"--ranks", "4", "--size", "96", "--quality", "best", "--tf", "grey", "--machine", machine})
          .at("prediction");
  CHECK(of_sheets.at("layouts").size() ==
        6);  // 3 + 1 … 1 + 3, and four colocated ranks of which four, two or one draw
  CHECK(of_sheets.at("visible_voxels").get<double>() >= visible);  // whole blocks
}

TEST_CASE("a forecast knows what a host's link takes to carry") {
  const Shell w;
  const auto seconds = [&](const std::string& bandwidth, int gps, const std::string& roles) {
    write_text(w / "machine.toml",
               "name = \"hosts of 8\"\npoll_interval = 1e-4\n[gp]\nvisible_voxel = 1e-8\n"
               "transparent_voxel = 1e-9\n[renderer]\nsplat = 1e-8\n[platform]\nkind = \"fat_tree\"\n"
               "latency = 1e-6\ncores = 8\nbandwidth = " +
                   bandwidth + "\n");
    const json all = w.predicted(
        {"--quality", "paper", "--size", "96x64", "--ranks", "16", "--machine", w / "machine.toml"});
    const json layouts = all.at("prediction").at("layouts");
    for (const json& layout : layouts)
      if (layout.at("topology") != "mesh" && layout.at("gps") == gps && layout.at("roles") == roles)
        return layout.at("seconds").get<double>();
    FAIL("no such layout");
    return 0.0;
  };
  // Half of what is sent stays on its host, or all of it goes from one to the other.
  CHECK(seconds("1e6", 16, "colocated") < 0.5 * seconds("1e6", 8, "dedicated"));
}
