// What may and may not go to standard output, and that nothing written there is lost.
#include <nlohmann/json.hpp>

#include "app/succeeded.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

struct Files {
  TemporaryFolder folder;
  std::string volume = folder / "ball.nrrd";
  Files() { REQUIRE(run_program({"synth", "ball", "-o", volume, "--dims", "20"}).code == 0); }
  Ended render(std::vector<std::string> more, int ranks = 0) const {
    more.insert(more.begin(), {"render", volume, "-o", folder / "x.png", "--size", "32"});
    return run_program(more, ranks);
  }
};

/// The current folder while it lives: relative file names would be created there.
class WorkingFolder {
 public:
  explicit WorkingFolder(const fs::path& folder) { fs::current_path(folder); }
  ~WorkingFolder() { fs::current_path(before_); }
  WorkingFolder(const WorkingFolder&) = delete;
  WorkingFolder& operator=(const WorkingFolder&) = delete;

 private:
  fs::path before_ = fs::current_path();
};

/// Runs the program with its standard output redirected by the shell.
int run_redirected(const std::vector<std::string>& arguments, const std::string& redirection) {
  std::string command = "timeout -k 2 60 " + quoted(RINGSPLAT_PROGRAM);
  for (const auto& argument : arguments) command.append(" ").append(quoted(argument));
  const int status = std::system((command + " " + redirection).c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

TEST_CASE("--stats - writes to stdout what it would write into a file, and nothing else goes there",
          "[mpi]") {
  const Files files;
  const WorkingFolder inside(files.folder.path());
  for (const int ranks : {0, 2}) {
    const Ended ended = succeeded(files.render({"--orbit", "2", "--stats", "-"}, ranks));
    CHECK(json::parse(ended.out).size() == 2);
    CHECK(lines_with(ended.err, "visible voxels").size() == 2);
    CHECK(lines_with(ended.err, "2 frames, median").size() == 1);
  }
  const Ended timed = run_program({"render", files.volume, "--stats", "-", "--size", "32"});
  CHECK(timed.code == 0);
  CHECK(json::parse(timed.out).size() == 1);
  CHECK_FALSE(fs::exists("-"));
}

TEST_CASE("--stats table, or a .txt, says by rank who worked and who waited", "[mpi]") {
  const Files files;
  const Ended two =
      succeeded(files.render({"--gps", "2", "--renderers", "1", "--orbit", "2", "--stats", "table"}, 3));
  CHECK_THAT(two.out, Contains("2 frames, sums") && Contains("busy") && Contains("waiting") &&
                          Contains("received MB") && Contains("blocks sent"));
  CHECK(lines_with(two.out, "GP ").size() == 2);
  CHECK(lines_with(two.out, "Renderer 0").size() == 1);
  const std::string file = files.folder / "stats.txt";
  REQUIRE(files.render({"--quality", "paper", "--stats", file}).code == 0);
  CHECK_THAT(read_text(file), Contains("1 frame, sums") && Contains("splats drawn"));
  CHECK_FALSE(fs::exists("table"));
}

TEST_CASE("a timeline and a transfer function can go to stdout, but one text only", "[mpi]") {
  const Files files;
  const Ended trace = succeeded(files.render({"--trace", "-"}));
  CHECK(json::parse(trace.out).contains("traceEvents"));
  const Ended function = succeeded(files.render({"--tf-out", "-"}));
  CHECK(json::parse(function.out).at(0).contains("RGBPoints"));
  const Ended truth = succeeded(
      run_program({"reference", files.volume, "-o", files.folder / "t.exr", "--size", "8", "--tf-out", "-"}));
  CHECK(json::parse(truth.out).at(0).contains("RGBPoints"));
  const Ended both = files.render({"--stats", "-", "--trace", "-"});
  CHECK(both.code == 2);
  CHECK(lines_with(both.err, "same file").size() == 1);
}

TEST_CASE("reference names the options that change nothing in its truth", "[mpi]") {
  const Files files;
  const auto warned = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"reference", files.volume, "-o", files.folder / "t.exr", "--size", "8"});
    const Ended ended = run_program(more);
    CHECK(ended.code == 0);
    return lines_with(ended.err, "warning");
  };
  CHECK(warned({}).empty());
  CHECK(warned({"--truth", "method", "--quality", "paper", "--radius", "1.4"}).empty());
  const auto field = warned({"--quality", "paper", "--radius", "1.4", "--region", "32"}),
             method = warned({"--truth", "method", "--tolerance", "0.01"});
  REQUIRE(field.size() == 1);
  CHECK_THAT(field[0],
             Catch::Matchers::Contains("--region, --radius, --quality change nothing in the field truth"));
  REQUIRE(method.size() == 1);
  CHECK_THAT(method[0], Catch::Matchers::Contains("--tolerance changes nothing in the method truth"));
}

TEST_CASE("pictures, volumes and tables go to files only") {
  const Files files;
  REQUIRE(files.render({}).code == 0);
  const std::string picture = files.folder / "x.png";
  const WorkingFolder inside(files.folder.path());
  const auto count = files_in(files.folder.path());
  for (const auto& arguments :
       std::vector<std::vector<std::string>>{{"render", files.volume, "-o", "-"},
                                             {"reference", files.volume, "-o", "-"},
                                             {"compare", picture, picture, "--diff", "-"},
                                             {"synth", "ball", "-o", "-"}}) {
    const Ended ended = run_program(arguments);
    INFO(arguments.front() << ": " << ended.err);
    CHECK(ended.code == 2);
    CHECK(ended.out.empty());
    CHECK(lines_with(ended.err, "cannot go to standard output").size() == 1);
  }
  CHECK(files_in(files.folder.path()) == count);
}

TEST_CASE("a stdout that is full fails the run") {
  const Files files;
  for (const auto& arguments : std::vector<std::vector<std::string>>{
           {"info", files.volume},
           {"render", "--help"},
           {"--man"},
           {"--completion", "bash"},
           {"synth", "--list"},
           {"info", "--presets"},
           {"render", files.volume, "--stats", "-", "--size", "32"},
           {"render", files.volume, "-o", files.folder / "x.png", "--size", "32"}}) {
    CHECK(run_redirected(arguments, ">/dev/full 2>" + quoted(files.folder / "err")) == 3);
    const std::string said = read_text(files.folder / "err");
    CHECK_THAT(said, Catch::Matchers::Contains("standard output cannot be written"));
    CHECK(said.find("report") == std::string::npos);
  }
}

TEST_CASE("a closed stdout does not put its lines into the files that are opened instead") {
  const Files files;
  const std::string with = files.folder / "with.json", without = files.folder / "without.json";
  const auto arguments = [&](const std::string& file) {
    return std::vector<std::string>{"render",   files.volume, "--size", "32",
                                    "--tf-out", file,         "-o",     file + ".png"};
  };
  REQUIRE(run_program(arguments(with)).code == 0);
  CHECK(run_redirected(arguments(without), ">&- 2>&- <&-") == 0);
  CHECK(read_text(with) == read_text(without));
  CHECK(read_text(with + ".png") == read_text(without + ".png"));
}
