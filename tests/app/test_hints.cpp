// Hints are run: what a refusal says to do instead works.
#include <algorithm>
#include <string>
#include <vector>

#include "app/parsed.hpp"
#include "app/workshop.hpp"
#include "formats/files.hpp"
#include "formats/npy.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;
using Catch::Matchers::Contains;

namespace {

/// A run that is refused, part of its hint, and the run that does what it says.
struct Hint {
  std::string refused, hint, run;
};

Words words_in(const std::string& text, const std::string& folder) {
  Words words = split(text);
  for (std::string& word : words)
    for (auto at = word.find("{}"); at != std::string::npos; at = word.find("{}"))
      word.replace(at, 2, folder);
  return words;
}

/// A hint's options are those of the run that follows it, or not, where it says to leave them out.
void check_follows(const Hint& hint, const Words& run) {
  const bool leave_out = hint.hint.find("leave") != std::string::npos;
  for (auto option : words_in(hint.hint, ""))
    if (option.starts_with("--")) {
      option.erase(option.find_last_not_of(",.:;") + 1);
      CHECK((std::find(run.begin(), run.end(), option) != run.end()) != leave_out);
    }
}

void check_all(const std::vector<Hint>& hints, const fs::path& folder) {
  for (const Hint& hint : hints) {
    const Words run = words_in(hint.run, folder.string());
    const Ended refused = run_program(words_in(hint.refused, folder.string()));
    CAPTURE(hint.refused, hint.run, refused.err);
    CHECK(refused.code == 2);
    const auto at = refused.err.find("hint: ");
    REQUIRE(at != std::string::npos);
    CHECK_THAT(refused.err.substr(at), Contains(hint.hint));
    check_follows(hint, run);
    const Ended followed = run_program(run);
    INFO(followed.err);
    CHECK(followed.code == 0);
  }
}

std::string nrrd(const std::string& fields, const std::string& voxels) {
  return "NRRD0004\ntype: uint8\nencoding: raw\n" + fields + "\n" + voxels;
}

}  // namespace

TEST_CASE("hints of refused volumes work") {
  const TemporaryFolder folder;
  std::string voxels;
  for (int i = 0; i < 64; ++i) voxels += char(4 * i);
  const auto put = [&](const std::string& name, const std::string& bytes) {
    write_text(folder / name, bytes);
  };
  put("a.nrrd", nrrd("dimension: 3\nsizes: 4 4 4\n", voxels));
  put("vector.nrrd", nrrd("dimension: 4\nsizes: 5 4 4 4\nkinds: vector domain domain domain\n",
                          voxels + voxels + voxels + voxels + voxels));
  put("b.raw", voxels);
  const std::string meta = "NDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\nElementSpacing = ";
  for (const std::string bad : {"0", "-1", "nan", "4.8e228"})
    put(bad + ".mha", meta + "1 " + bad + " 1\nElementDataFile = LOCAL\n" + voxels);
  put("film.npy", files::npy("|u1", "(2, 5, 4, 5)") + voxels + voxels + voxels + voxels.substr(56));
  fs::create_directory(folder / "volumes");
  put("volumes/a.mha", meta + "1 1 1\nElementDataFile = LOCAL\n" + voxels);
  check_all(
      {
          {"info {}/0.mha", "for instance --spacing 1x1x1", "info {}/0.mha --spacing 1x1x1"},
          {"info {}/-1.mha", "for instance --spacing 1x1x1", "info {}/-1.mha --spacing 1x1x1"},
          {"render {}/4.8e228.mha -o {}/x.png", "for instance --spacing 1x1x1",
           "render {}/4.8e228.mha --spacing 1x1x1 -o {}/x.png --size 32"},
          {"info {}/b.raw", "give --dims 256x256x128 --type uint8",
           "info {}/b.raw --dims 4x4x4 --type uint8"},
          {"info {}/a.nrrd --dims 4", "leave them out; only --spacing may be given", "info {}/a.nrrd"},
          {"info {}/vector.nrrd", "choose one with --channel", "info {}/vector.nrrd --channel 4"},
          {"info {}/a.nrrd --channel 1", "leave --channel out", "info {}/a.nrrd"},
          {"info {}/a.nrrd --series 1", "leave --series out", "info {}/a.nrrd"},
          {"info {}/film.npy --frame 2", "frames are numbered from 0 to 1", "info {}/film.npy --frame 1"},
          {"render {}/a.nr?d -o {}/x.png", "add --frames all",
           "render {}/a.nr?d -o {}/x.png --frames all --size 32"},
          {"info {}/volumes", "name one of them, as " + (folder / "volumes/a.mha"), "info {}/volumes/a.mha"},
      },
      folder.path());
}

TEST_CASE("hints of refused options work") {
  const TemporaryFolder folder;
  REQUIRE(run_program({"synth", "shell", "-o", folder / "a.nrrd", "--dims", "12"}).code == 0);
  const std::string start = "render {}/a.nrrd -o {}/x.png --size 32 ";
  std::vector<Hint> hints{
      {"--samples 2", "leave out --samples or use --image-plane slices", ""},
      {"--prefilter", "add --undersample 2", "--prefilter --undersample 2"},
      {"--error-pixels 99", "add --error method", "--error-pixels 99 --error method"},
      {"--mesh 2x2", "add --topology mesh, or leave it out", ""},
      {"--shading none --ambient 0.3", "leave out --ambient or use --shading phong", ""},
      {"--light 0 0 0", "for instance --light -0.4 0.6 0.7", "--light -0.4 0.6 0.7"},
      {"--max-error 0", "for instance --max-error 0.5", "--max-error 30"},
      {"--up 0 1 0", "add --eye", "--up 0 0 1 --eye 3 0 0"},
      {"--fov 40", "add --projection perspective", "--fov 40 --projection perspective"},
      {"--quality paper --fov 40 --projection perspective", "use --engine sheets, or leave --fov out", ""},
      {"--gps 2 --mesh 2x2 --topology mesh", "leave out --gps", "--mesh 2x2 --topology mesh"},
  };
  for (Hint& hint : hints) hint.refused = start + hint.refused, hint.run = start + hint.run;
  check_all(hints, folder.path());
}
