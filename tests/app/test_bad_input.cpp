// Wrong input ends soon with one clear line, a hint and exit code 2, and leaves nothing behind.
#include <dlfcn.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "app/parsed.hpp"
#include "app/workshop.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;

namespace {

struct Case {
  std::string words;      ///< '' stands for an empty one
  std::string fragment;   ///< of the error line
  bool with_mpi = false;  ///< under mpirun -n 3 too
};

/// Bad files, and a good volume.
class Inputs {
 public:
  Inputs() {
    const std::string header = "NRRD0004\ntype: uint8\ndimension: 3\nencoding: raw\n";
    write_text(folder_ / "good_4x4x4_uint8.raw", [] {
      std::string voxels;
      for (int i = 0; i < 64; ++i) voxels += static_cast<char>(4 * i);
      return voxels;
    }());
    write_text(folder_ / "good.nrrd",
               header + "sizes: 4 4 4\n\n" + read_text(folder_ / "good_4x4x4_uint8.raw"));
    write_text(folder_ / "truncated.nrrd", header + "sizes: 64 64 64\n\n" + std::string(1000, 'x'));
    write_text(folder_ / "huge_claim.nrrd", header + "sizes: 2048 1024 1024\n\n" + std::string(1024, 'x'));
    write_text(folder_ / "zero_dimension.nrrd", header + "sizes: 4 0 4\n\n");
    write_text(folder_ / "wrong_size_8x8x8_uint8.raw", std::string(100, 'x'));
    write_text(folder_ / "no_dimensions.raw", std::string(64, 'x'));
    write_text(folder_ / "nan_4x4x4_float32.raw", [] {
      std::string bytes(64 * sizeof(float), '\0');
      const float nan = std::numeric_limits<float>::quiet_NaN();
      for (std::size_t i = 0; i < 64; ++i) std::memcpy(bytes.data() + i * sizeof(float), &nan, sizeof(float));
      return bytes;
    }());
    write_text(folder_ / "letter.txt", "Dear reader,\n");
    fs::create_directory(folder_ / "empty_folder");
    fs::create_directory(folder_ / "stack");
    for (const char* name : {"stack/0.png", "stack/1.png"}) write_text(folder_ / name, "not to be replaced");
    const auto sparse = folder_ / "sparse_16000x12500x5000_uint8.raw";
    write_text(sparse, "");
    fs::resize_file(sparse, std::uintmax_t{1'000'000'000'000});

    write_text(
        folder_ / "good.json",
        R"([{"RGBPoints": [0, 0, 0, 0, 9, 1, 1, 1], "Points": [0, 0, 0.5, 0, 9, 1, 0.5, 0], "Name": "good"}])");
    write_text(folder_ / "one_point.json",
               R"([{"RGBPoints": [0, 1, 1, 1], "Points": [0, 1, 0.5, 0], "Name": "one"}])");
    write_text(folder_ / "not_json.json", "RGBPoints: 0 1 1 1\n");
    write_text(folder_ / "bad_path.csv", "0 0\n10 up\n");
    write_text(folder_ / "empty_path.csv", "# nothing\n\n");
    write_text(folder_ / "zero_zoom_path.csv", "0 0 0 1\n10 0 0 0\n");
    write_text(folder_ / "unknown_key.toml", "gpss = 4\n");
    write_text(folder_ / "contradiction.toml", "orbit = 3\n");
  }
  std::string operator/(const std::string& name) const { return folder_ / name; }

 private:
  TemporaryFolder folder_;
};

// A first word that is + stands for "render {in}/good.nrrd -o {out}/x.png".
const std::vector<Case> command_line_cases{
    {"+ --max-error 0", "--max-error"},
    {"+ --max-error nan", "--max-error"},
    {"+ --max-error few", "--max-error"},
    {"+ --engine sheets --slabs 0", "--slabs cannot be 0"},
    {"+ --engine sheets --light-points 3", "--light-points cannot be 3"},
    {"+ --range 5", "is no window"},
    {"+ --range 9:5", "does not ascend"},
    {"+ --range 5:inf", "is not finite"},
    {"+ --opacity 0", "no number above 0"},
    {"+ --colours virids", "no colour map"},
    {"+ --log --range 0:5", "only positive"},
    {"+ --view above", "front|back|left|right|top|bottom"},
    {"+ --clip 0:4,0:5,0:4", "the y part, '0:5', does not lie within the volume", true},
    {"+ --clip-plane 1,0,0,0 --quality paper", "--clip-plane has no effect on splats"},
    {"+ --slice plane:1,1,0", "--slice plane: '1,1,0' is no plane"},
    {"+ --gps some", "--gps cannot be 'some'"},
    {"", "subcommand"},
    {"rendr {in}/good.nrrd", "did you mean render?"},
    {"render -o {out}/x.png", "VOLUME", true},
    {"render {in}/good.nrrd", "--output"},
    {"render {in}/good.nrrd --count-only -o {out}/x.png", "--count-only and --output"},
    {"+ --voxel-weight 4", "--voxel-weight"},
    {"+ --machine {in}/none.toml", "none.toml"},
    {"+ --sizee 512", "did you mean --size?", true},
    {"+ --window 0:80", "did you mean --range?"},
    {"+ --colormap viridis", "did you mean --colours? --tf changes"},
    {"+ --mip", "did you mean --mode?"},
    {"+ --resolution 512", "did you mean --size?"},
    {"+ --threads 2", "did you mean --threads-per-rank?"},
    {"info {in}/good.nrrd --roi 1:2", "did you mean --clip?"},
    {"+ extra", "'extra' is not expected"},
    {"+ --size 0x0", "image size 0x0", true},
    {"+ --size 512x", "'512x' is no image size"},
    {"+ --size -5", "image size -5x-5"},
    {"+ --size 1000000x1000000", "GiB"},
    {"+ --region 0", "--region"},
    {"+ --image-plane sky", "screen|slices"},
    {"+ --image-plane slices --samples 3", "--samples cannot be 3"},
    {"+ --zoom 0", "zoom"},
    {"+ --quality paper --zoom 1e30", "kernel"},
    {"+ --azimuth inf", "azimuth"},
    {"+ --azimuth north", "--azimuth"},
    {"+ --quality paper --radius 0", "radius 0"},
    {"+ --light 0 1", "--light"},
    {"+ --ambient -1", "Phong"},
    {"+ --matrix 0 0 0 0 0 0 0 0 0 0 0 0", "matrix"},
    {"+ --matrix 1 0 0", "--matrix"},
    {"+ --routing direct", "--routing has no effect in a ring"},
    {"+ --topology mesh", "--topology mesh needs a shape"},
    {"+ --background nocolour", "no colour"},
    {"+ --orbit 0", "--orbit"},
    {"+ --orbit ''", "--orbit"},
    {"+ --orbit 10000000000000000000000", "--orbit"},
    {"+ --path ''", "--path is empty"},
    {"+ --gps 0", "--gps is 0"},
    {"+ --renderers -1", "--renderers is -1"},
    {"+ --gps 100000", "too many for one process"},
    {"+ --slots 0", "slots"},
    {"+ --frames-in-flight 0", "frames"},
    {"+ --look-ahead 0", "look"},
    {"+ --send-ahead -1", "--send-ahead is -1"},
    {"+ --threads-per-rank 0", "at least 1"},
    {"+ --threads-per-rank 100000", "for each core"},
    {"+ --stall-timeout 0", "stall"},
    {"render {in}/no_dimensions.raw -o {out}/x.png --dims 4 --type uint8 --offset -1", "--offset"},
};

const std::vector<Case> contradictions{
    {"+ --labels --log", "contradict"},
    {"+ --labels --tf grey", "contradict"},
    {"+ --view top --azimuth 10", "--view and --azimuth contradict each other"},
    {"+ --view top --eye 1 2 300", "contradict"},
    {"+ --fit box --matrix 1 0 0 0 0 1 0 0 0 0 1 0", "contradict"},
    {"+ --fit box --projection perspective --quality best --distance 4", "contradict"},
    {"+ --fit box --projection perspective --quality best --eye 1 2 300", "--fit has no effect"},
    {"+ --error analytic", "formula"},
    {"+ --guarantee --error certified", "--max-error"},
    {"+ --guarantee --error field --max-error 1", "--error certified"},
    {"+ --error-map {out}/map.png", "--error"},
    {"+ --error field --error-map {out}/map.jpg", "--error-map"},
    {"+ --gps auto", "mpirun -n N"},
    {"render {in}/good.nrrd --stats - --annotate", "--annotate has no effect without --output"},
    {"+ --orbit 3 --path {in}/bad_path.csv", "--orbit and --path", true},
    {"+ --topology mesh --mesh 2x2 --send-ahead 4", "--mesh and --send-ahead"},
    {"+ --orbit 3 --matrix 1 0 0 0 0 1 0 0 0 0 1 0", "--matrix and --orbit"},
    {"+ --azimuth 3 --matrix 1 0 0 0 0 1 0 0 0 0 1 0", "--matrix and --azimuth"},
    {"+ --shading none --light 0 0 1", "no effect"},
    {"+ --error-seed 3", "no effect"},
    {"+ --link-slots 2", "no effect"},
    {"render {in}/good.nrrd --count-only --max-error 3", "--count-only and --max-error"},
    {"render {in}/good.nrrd --count-only --error method", "--count-only and --error"},
    {"+ --layers 3", "--layers"},
    {"+ --layers 0", "--layers"},
    {"+ --layers 2147483647", "--layers"},
    {"+ --layers 16 --mode mip", "--layers and --mode contradict"},
    {"+ --layers 16 --quality paper", "--layers has no effect on splats"},
    {"render {in}/good.nrrd --layers 16 --count-only --stats {out}/x.json", "--count-only and --layers"},
    {"+ --stats {out}/x.png", "same file", true},
    {"+ --stats {out}/./x.png", "same file"},
    {"+ --trace {in}/good.nrrd", "would replace the volume"},
    {"+ --tf {in}/good.json --tf-out {in}/good.json", "would replace --tf"},
    {"render {in}/stack -o {in}/stack/1.png", "among the slices of the volume"},
    {"+ --config {in}/contradiction.toml --path {in}/bad_path.csv", "--orbit and --path"},
    {"+ --dims 4x4x4", "only --spacing"},
    {"+ --depth 0.5", "cannot hold --depth"},
    {"render {in}/good.nrrd -o {out}/x.exr --depth 1", "--depth 1 is no opacity"},
    {"render {in}/good.nrrd -o {out}/x.exr --depth 0.5 --mode mip", "--depth and --mode contradict"},
    {"render {in}/good.nrrd -o {out}/x.exr --depth 0.5 --slice x=1", "--depth and --slice contradict"},
    {"+ --cut q=3", "--cut 'q=3' names no slice"},
    {"+ --cut plane:0,0,0,1", "needs a direction of finite length"},
    {"+ --cut x=100000", "--cut"},
    {"+ --cut x=1 --mode sum", "--cut and --mode contradict"},
    {"+ --cut x=1 --quality paper", "--cut has no effect on splats"},
    {"+ --cut x=1 --clip-plane 1,0,0,0:0,1,0,0:0,0,1,0", "3 clip planes are too many"},
    {"render {in}/good.nrrd -o {out}/x.exr --depth 0.5 --channel 0,1", "--depth and --channel contradict"},
    {"render {in}/good.nrrd -o {out}/x.exr --depth 0.5 --quality paper", "--depth has no effect on splats"},
    {"+ --mode mip --specular 0.5", "--specular has no effect where values are shown instead of light"},
    {"+ --materials", "--materials has no effect without --channel"},
    {"+ --materials --channel 0,1 --mode mip", "--mode and --materials contradict"},
    {"render {in}/good.nrrd -o {out}/x.exr --values --mode composite", "--values and --mode contradict"},
    {"reference {in}/good.nrrd -o {out}/x.exr --depth 0.5 --truth certified",
     "--depth and --truth contradict"},
};

const std::vector<Case> volume_cases{
    {"render {in}/missing.nrrd -o {out}/x.png", "missing.nrrd", true},
    {"render {in}/truncated.nrrd -o {out}/x.png", "truncated.nrrd", true},
    {"render {in}/huge_claim.nrrd -o {out}/x.png", "huge_claim.nrrd", true},
    {"render {in}/zero_dimension.nrrd -o {out}/x.png", "zero_dimension.nrrd"},
    {"render {in}/wrong_size_8x8x8_uint8.raw -o {out}/x.png", "512"},
    {"render {in}/no_dimensions.raw -o {out}/x.png", "no_dimensions.raw"},
    {"render {in}/no_dimensions.raw -o {out}/x.png --dims 0x4x4 --type uint8", "--dims"},
    {"render {in}/no_dimensions.raw -o {out}/x.png --dims 4x4x4 --type uint9", "uint9"},
    {"render {in}/no_dimensions.raw -o {out}/x.png --dims 4 --type uint8 --endian middle", "--endian"},
    {"render {in}/no_dimensions.raw -o {out}/x.png --dims 4 --type uint8 --spacing 0", "--spacing"},
    {"render {in}/no_dimensions.raw -o {out}/x.png --dims 4 --type uint8 --offset 60", "--offset"},
    {"render {in}/nan_4x4x4_float32.raw -o {out}/x.png", "no finite value", true},
    {"render {in}/letter.txt -o {out}/x.png", "letter.txt"},
    {"render {in}/empty_folder -o {out}/x.png", "empty_folder"},
    {"render {in}/sparse_16000x12500x5000_uint8.raw -o {out}/x.png --view front", "GiB", true},
};

const std::vector<Case> small_file_cases{
    {"+ --tf nonsense", "neither a preset nor a file", true},
    {"+ --tf mr-sof", "did you mean mr-soft?"},
    {"+ --tf {in}/missing.json", "missing.json"},
    {"+ --tf {in}/one_point.json", "one_point.json", true},
    {"+ --tf {in}/not_json.json", "not_json.json"},
    {"+ --path {in}/missing.csv", "missing.csv"},
    {"+ --path {in}/empty_folder", "empty_folder"},
    {"+ --path {in}/bad_path.csv", "bad_path.csv:2"},
    {"+ --path {in}/empty_path.csv", "no view"},
    {"+ --path {in}/zero_zoom_path.csv", "zero_zoom_path.csv:2: the zoom 0"},
    {"+ --config {in}/missing.toml", "missing.toml"},
    {"+ --config {in}/unknown_key.toml", "gpss", true},
};

const std::vector<Case> output_cases{
    {"+ --trace {out}/missing/trace.json", "--trace", true},
    {"+ --trace {out}", "--trace"},
    {"+ --trace {out}/x.png", "--trace"},
    {"+ --stats - --trace -", "same file"},
    {"render {in}/good.nrrd -o -", "cannot go to standard output"},
    {"reference {in}/good.nrrd -o -", "cannot go to standard output"},
    {"compare {in}/a.png {in}/b.png --diff -", "cannot go to standard output"},
    {"synth ball -o -", "cannot go to standard output"},
    {"render {in}/good.nrrd -o {out}/missing/x.png", "no folder", true},
    {"render {in}/good.nrrd -o {out}/x.xyz", "x.xyz"},
    {"render {in}/good.nrrd -o {out}", "picture format"},
    {"render {in}/good.nrrd -o /proc/x.png", "cannot be written"},
    {"render {in}/good.nrrd -o {out}/x.jpg", "transparency"},
    {"+ --stats {out}/missing/stats.json", "--stats"},
    {"+ --tf-out /proc/tf.json", "--tf-out"},
};

const std::vector<Case> other_subcommands{
    {"reference {in}/good.nrrd -o {out}/x.exr --truth analytic", "--formula"},
    {"reference {in}/good.nrrd -o {out}/x.exr --truth analytic --formula cow", "cow"},
    {"reference {in}/good.nrrd -o {out}/x.exr --formula ball", "no effect"},
    {"reference {in}/good.nrrd -o {out}/x.exr --truth gut", "gut"},
    {"reference {in}/good.nrrd -o {out}/x.exr --truth certified --mode mip --values", "--values"},
    {"reference {in}/good.nrrd -o {out}/x.exr --clip 3:3,,", "the x part, '3:3', has no voxel"},
    {"info {in}/good.nrrd --clip 3:3,,", "the x part, '3:3', has no voxel"},
    {"info {in}/good.nrrd --azimuth 30", "--ranks"},
    {"info {in}/good.nrrd --cores 2", "--ranks"},
    {"info {in}/good.nrrd --machine x.toml", "--ranks"},
    {"info {in}/good.nrrd --quality paper", "--ranks"},
    {"info {in}/good.nrrd --ranks 0", "--ranks"},
    {"info {in}/good.nrrd --ranks 2 --machine {in}/none.toml", "none.toml"},
    {"info", "VOLUME"},
    {"info {in}/good.nrrd --gps 0", "--gps"},
    {"info {in}/good.nrrd --presets", "--presets and volume"},
    {"info {in}/good.nrrd --tf-out {out}/x.json", "--tf-out"},
    {"info {in}/truncated.nrrd", "truncated.nrrd", true},
    {"compare {in}/good.nrrd", "b is required"},
    {"compare {in}/missing.png {in}/missing.png", "missing.png", true},
    {"compare {in}/letter.txt {in}/letter.txt", "letter.txt"},
    {"compare {in}/letter.txt {in}/letter.txt --fail-above -1", "--fail-above"},
    {"compare {in}/letter.txt {in}/letter.txt --diff-scale 2", "no effect"},
    {"synth --list ball", "--list and name"},
    {"synth --list -o {out}/x.nrrd", "--list and --output"},
    {"synth nonsense -o {out}/x.nrrd", "nonsense"},
    {"synth ball", "-o FILE"},
    {"synth -o {out}/x.nrrd", "NAME"},
    {"synth ball -o {out}/x.xyz", "x.xyz"},
    {"synth ball -o {out}/missing/x.nrrd", "no folder"},
    {"synth ball -o {out}/x.nrrd --dims 100000", "KiB, but the disk has"},
};

std::vector<Case> all_cases() {
  std::vector<Case> all;
  for (const auto* cases : {&command_line_cases, &contradictions, &volume_cases, &small_file_cases,
                            &output_cases, &other_subcommands})
    all.insert(all.end(), cases->begin(), cases->end());
  return all;
}

Words words_of(const Case& c, const std::string& in, const std::string& out) {
  Words words;
  for (std::string word : split(c.words)) {
    if (word == "+") {
      words = {"render", in + "/good.nrrd", "-o", out + "/x.png"};
      continue;
    }
    if (word == "''") word.clear();
    for (const auto& [name, folder] : {std::pair{std::string("{in}"), in}, {"{out}", out}})
      if (const auto at = word.find(name); at != std::string::npos) word.replace(at, name.size(), folder);
    words.push_back(word);
  }
  return words;
}

/// True within two seconds without the launcher's own time, which grows with the machine's load.
bool ended_soon(const Ended& ended, int ranks) {
  return ended.seconds < 2 || (ranks > 0 && ended.seconds < 2 + run_program({"--version"}, ranks).seconds);
}

void check_case(const Case& c, const Inputs& inputs, int ranks) {
  const TemporaryFolder out;
  const Words arguments = words_of(c, fs::path(inputs / ".").parent_path().string(), out.path().string());
  INFO("ringsplat " << c.words << " on " << ranks << " ranks");
  // The best of a few, as the machine may be busy with other work.
  Ended ended;
  bool soon = false;
  for (int attempt = 0; attempt < 4 && !soon; ++attempt) {
    ended = run_program(arguments, ranks);
    soon = ended_soon(ended, ranks);
  }
  INFO("stderr: " << ended.err);
  CHECK(ended.code == 2);
  CHECK(ended.out.empty());
  const auto errors = lines_with(ended.err, "error:");
  CHECK(errors.size() == 1);
  if (errors.size() != 1) return;
  CHECK(errors.front().find("ringsplat: error: ") == 0);
  CHECK_THAT(errors.front(), Catch::Matchers::Contains(c.fragment));
  CHECK_THAT(errors.front(), Catch::Matchers::Contains("; hint: "));
  if (ranks == 0) CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') == 1);
  CHECK(files_in(out.path()) == 0);
  CHECK(soon);
}

}  // namespace

TEST_CASE("bad input is refused in one line in one process", "[mpi]") {
  const Inputs inputs;
  for (const auto& c : all_cases()) check_case(c, inputs, 0);
}

TEST_CASE("bad input is refused in one line on all ranks", "[mpi]") {
  const Inputs inputs;
  for (const auto& c : all_cases())
    if (c.with_mpi) check_case(c, inputs, 3);
}

TEST_CASE("options that do not fit the launcher's ranks are refused", "[mpi]") {
  const Inputs inputs;
  const std::vector<Case> wrong{
      {"+ --gps 4 --renderers 2", "need 6, but the job has 3"},
      {"+ --gps 3", "need 4, but the job has 3"},
      {"+ --gps 2 --renderers 2 --roles colocated", "need 2, but the job has 3"},
      {"+ --transport loopback", "the launcher started 3"},
      {"+ --gps auto --renderers 7", "3 ranks cannot be given such roles"},
      {"+ --renderers auto --topology mesh --mesh 2x1", "has no effect in a mesh"},
  };
  for (const auto& c : wrong) check_case(c, inputs, 3);
}

TEST_CASE("an image library that cannot be used is noticed before a picture is drawn") {
  const Inputs inputs;
  const TemporaryFolder out;
  Dl_info other;  // any library that has no images
  REQUIRE(dladdr(reinterpret_cast<void*>(&std::puts), &other) != 0);
  for (const auto& entry : fs::directory_iterator(fs::path(RINGSPLAT_PROGRAM).parent_path() / "src"))
    if (const auto name = entry.path().filename().string(); name.starts_with("libringsplat_openimageio.so"))
      fs::create_symlink(other.dli_fname, out / name);
  const auto files = files_in(out.path());
  const Ended ended =
      run_command("env LD_LIBRARY_PATH=" + quoted(out.path().string()) + " " +
                  command_of(RINGSPLAT_PROGRAM, {"render", inputs / "good.nrrd", "-o", out / "x.png"}));
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err,
             Catch::Matchers::StartsWith("ringsplat: error: images can be neither read nor written"));
  CHECK(files_in(out.path()) == files);
}

TEST_CASE("few libraries are loaded by every rank, and none that reads files") {
  const Ended ended = run_command("env LD_TRACE_LOADED_OBJECTS=1 " + command_of(RINGSPLAT_PROGRAM, {}));
  CHECK(lines_with(ended.out, "lib").size() <= 30);
  CHECK_FALSE(ended.out.empty());
  for (const std::string reader : {"hdf5", "gdcm", "OpenImageIO", "ITK"})
    CHECK(lines_with(ended.out, reader).empty());
}

TEST_CASE("a missing program for what libraries read is named with where it belongs") {
  const TemporaryFolder away;
  fs::copy_file(RINGSPLAT_PROGRAM, away / "ringsplat");
  const auto file = fs::path(RINGSPLAT_TEST_DATA) / "../fuzz/crashes/hdf5/never_closes";
  const Ended ended = run_command("env PATH=/bin " + command_of(away / "ringsplat", {"info", file.string()}));
  CHECK(ended.code == 2);
  CHECK_THAT(ended.err,
             Catch::Matchers::Contains("ringsplat-decode, which reads DICOM, TIFF and HDF5, is missing") &&
                 Catch::Matchers::Contains("here in " + away.path().string()));
}

TEST_CASE("what HDF5 says of damaged files does not reach stderr") {
  for (const auto& entry : fs::directory_iterator(fs::path(RINGSPLAT_TEST_DATA) / "../fuzz/crashes/hdf5")) {
    const Ended ended = run_program({"info", entry.path().string()});
    CAPTURE(entry.path(), ended.err);
    CHECK(ended.code == 2);
    CHECK(lines_with(ended.err, "").size() == lines_with(ended.err, "ringsplat: ").size());
  }
}

TEST_CASE("a good volume is not refused") {
  // The common part of the cases above must work, or they would fail for the wrong reason.
  const Inputs inputs;
  const TemporaryFolder out;
  const Ended ended = run_program({"render", inputs / "good.nrrd", "-o", out / "x.png", "--size", "32"});
  INFO(ended.err);
  CHECK(ended.code == 0);
  CHECK(files_in(out.path()) == 1);
}
