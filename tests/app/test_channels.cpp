// Several channels of a volume in one picture.
#include <array>
#include <nlohmann/json.hpp>

#include "app/workshop.hpp"
#include "formats/files.hpp"
#include "images/image_io.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app_test;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

/// Two and seven channels of one lattice.
struct Stacks {
  TemporaryFolder folder;
  Stacks() {
    for (const int channels : {2, 7}) {
      std::string voxels;
      for (int z = 0; z < 10; ++z)
        for (int y = 0; y < 12; ++y)
          for (int x = 0; x < 14; ++x)
            for (int c = 0; c < channels; ++c)
              voxels += files::bytes_of(
                  std::uint16_t(100 + (x * (7 + 5 * c) + y * y * (1 + c) + z * 31) % 97 * 40));
      write_text(file(channels),
                 "NRRD0004\ntype: uint16\nendian: little\ndimension: 4\nsizes: " + std::to_string(channels) +
                     " 14 12 10\nkinds: vector domain domain domain\nencoding: raw\n\n" + voxels);
    }
  }
  std::string file(int channels) const { return folder / (std::to_string(channels) + ".nrrd"); }
  Ended run(const std::string& channels, const Words& more = {}, int ranks = 0) const {
    const Words words{"render", file(2), "--channel", channels, "-o", folder / "x.exr", "--size", "48x40"};
    return run_program(joined(words, more), ranks);
  }
  std::string bytes(const std::string& channels, const Words& more = {}, int ranks = 0) const {
    succeeded(run(channels, more, ranks));
    return read_text(folder / "x.exr");
  }
  Image picture(const std::string& channels, const Words& more = {}) const {
    bytes(channels, more);
    return read_image(folder / "x.exr").image;
  }
};

}  // namespace

TEST_CASE("info lists the channels as they are drawn together, and those that are not") {
  const TemporaryFolder folder;
  const fs::path store = folder / "cells.zarr";
  fs::create_directories(store / "0");
  write_text(store / ".zgroup", R"({"zarr_format":2})");
  write_text(store / ".zattrs", R"({"multiscales":[{"version":"0.4","axes":[{"name":"c","type":"channel"},
    {"name":"z","type":"space"},{"name":"y","type":"space"},{"name":"x","type":"space"}],"datasets":[{"path":"0",
    "coordinateTransformations":[{"type":"scale","scale":[1,1,1,1]}]}]}],"omero":{"channels":[
    {"label":"DAPI","color":"0000FF","window":{"start":10,"end":200,"min":0,"max":255}},
    {"label":"green fluorescent protein, in more words than have room in a list"},
    {"label":"light","color":"FFFFFF","active":false}]}})");
  write_text(store / "0/.zarray",
             R"({"zarr_format":2,"shape":[3,2,4,5],"chunks":[1,2,4,5],"dtype":"|u1","order":"C",
    "compressor":null,"fill_value":0,"filters":null})");
  for (const char* const chunk : {"0.0.0.0", "1.0.0.0", "2.0.0.0"})
    write_text(store / "0" / chunk, "the forty voxels of a small chunk, 8 bit");
  const Ended text = run_program({"info", store, "--channel", "1"});
  INFO(text.err);
  CHECK_THAT(text.out, Contains("channel 0  DAPI, #0000ff, values from 10 to 200\n") &&
                           Contains("channel 1  green fluorescent protein") && Contains(", #00ff00\n") &&
                           Contains("channel 2  light, #ffffff; not in --channel all\n"));
  const auto channels = json::parse(run_program({"info", store, "--json"}).out).at("channels");
  CHECK(channels.at(0) == json::parse(R"({"name":"DAPI","colour":[0,0,1],"window":[10,200],"drawn":true})"));
  CHECK(channels.at(1).at("name") == "green fluorescent protein, in more words than have room in a list");
  CHECK_THAT(run_program({"info", Stacks().file(7), "--channel", "0"}).out,
             Contains("channel 6  channel 6; not in --channel all\n"));
  CHECK(channels.at(2) == json::parse(R"({"name":"light","colour":[1,1,1],"window":null,"drawn":false})"));
}

TEST_CASE("channels are added, each in its colour") {
  const Stacks stacks;
  const auto mode = GENERATE(as<std::string>{}, "mip", "sum", "attenuated");
  const Image one = stacks.picture("0=white", {"--mode", mode}),
              other = stacks.picture("1=white", {"--mode", mode}),
              both = stacks.picture("0,1", {"--mode", mode});
  REQUIRE(both.rgba.size() == one.rgba.size());
  for (int y = 0; y < both.height; ++y)
    for (int x = 0; x < both.width; ++x) {
      const float *a = one.pixel(x, y), *b = other.pixel(x, y), *sum = both.pixel(x, y);
      // Magenta and green are the usual colours of two.
      const std::array<float, 4> wanted{a[0], b[1], a[2], std::min(1.0F, a[3] + b[3])};
      if (!std::equal(wanted.begin(), wanted.end(), sum)) FAIL("pixel " << x << ", " << y);
    }
  CHECK((stacks.bytes("all", {"--mode", mode}) == stacks.bytes("0=magenta,1=#00ff00", {"--mode", mode})));
}

TEST_CASE("light through several channels is added up to 1") {
  const Stacks stacks;
  const std::vector<std::string> more{"--mode", "composite", "--opacity", "3"};
  Image sum = stacks.picture("0=yellow", more);
  const Image other = stacks.picture("1=red", more);
  for (std::size_t k = 0; k < sum.rgba.size(); ++k) sum.rgba[k] = std::min(1.0F, sum.rgba[k] + other.rgba[k]);
  CHECK(stacks.picture("0=yellow,1=red", more) == sum);
}

TEST_CASE("a picture of channels has the same bits on any ranks", "[mpi]") {
  const Stacks stacks;
  struct Case {
    Words picture, layout;
    int ranks;
  };
  const std::vector<Case> cases{
      {{}, {"--threads-per-rank", "2"}, 2},
      {{"--mode", "composite"}, {"--gps", "2", "--renderers", "1"}, 3},
      {{"--quality", "paper"}, {"--topology", "mesh", "--mesh", "2x1", "--renderers", "1"}, 3}};
  for (const auto& [picture, layout, ranks] : cases) {
    CAPTURE(picture, layout);
    CHECK((stacks.bytes("1,0", joined(picture, layout), ranks) == stacks.bytes("1,0", picture)));
  }
  const auto orbit = [&](const Words& layout, int ranks) {
    succeeded(stacks.run("1,0", joined({"--orbit", "3"}, layout), ranks));
    return read_text(stacks.folder / "x-0000.exr") + read_text(stacks.folder / "x-0002.exr");
  };
  CHECK((orbit({"--gps", "2", "--renderers", "1"}, 3) == orbit({}, 0)));
}

TEST_CASE("channels whose opacity goes by gradients are light") {
  const Stacks stacks;
  stacks.bytes("0,1", {"--tf2d", "1:1000"});
  const auto settings = json::parse(read_image(stacks.folder / "x.exr").settings);
  CHECK_FALSE(settings.contains("mode"));
  CHECK(settings.at("edges") == json::array({1, 1000}));
}

TEST_CASE("a series of channels has the transfer functions of the first volume") {
  const Stacks stacks;
  fs::copy_file(stacks.file(2), stacks.folder / "s_0.nrrd");
  fs::copy_file(stacks.file(2), stacks.folder / "s_1.nrrd");
  succeeded(run_program({"render", stacks.folder / "s_*.nrrd", "--frames", "all", "--channel", "0,1", "-o",
                         stacks.folder / "s.png", "--size", "48x40", "--stats", stacks.folder / "s.json"}));
  stacks.bytes("0,1");
  for (const char* name : {"s-0000.png", "s-0001.png"}) CHECK(fs::exists(stacks.folder / name));
  const json stats = json::parse(read_text(stacks.folder / "s.json"));
  CHECK(stats.size() == 2);
  CHECK(stats[1].at("volume") == stacks.folder / "s_1.nrrd");
  const auto settings = json::parse(read_image(stacks.folder / "s-0001.png").settings);
  CHECK(settings.at("channels").size() == 2);
  CHECK(settings.at("mode") == "mip");
}

TEST_CASE("what several channels cannot have is refused in a line") {
  const Stacks stacks;
  for (const std::string option : {"--values", "--labels"})
    check_refused(stacks.run("0,1", {option}), option + " is for one");
  check_refused(stacks.run("all", {"--error", "method"}), "--error is for one");
  check_refused(stacks.run("0,2"), "no such channel");
  check_refused(stacks.run("1,0,1"), "channel 1 is there twice");
  check_refused(stacks.run("0,1=mauve"), "'mauve' is no colour");
  check_refused(run_program({"info", stacks.file(2), "--channel", "all"}), "shows one channel");
  for (const Words& words : {Words{"serve", stacks.file(7)}, {"render", stacks.file(7), "-o", "y.png"}})
    check_refused(run_program(joined(words, {"--channel", "all"})), "7 channels are too many");
}
