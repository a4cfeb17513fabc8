// What may and may not go to standard output, and that nothing written there is lost.
#include <nlohmann/json.hpp>

#include "app/workshop.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

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
  const std::string command = "timeout -k 2 60 " + command_of(RINGSPLAT_PROGRAM, arguments);
  const int status = std::system((command + " " + redirection).c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

TEST_CASE("--stats - writes to stdout what it would write into a file, and nothing else goes there",
          "[mpi]") {
  const Workshop files("ball", "20", {"--size", "32"});
  const WorkingFolder inside(files.path());
  for (const int ranks : {0, 2}) {
    const Ended ended = files.render("x.png", {"--orbit", "2", "--stats", "-"}, ranks);
    CHECK(json::parse(ended.out).size() == 2);
    CHECK(lines_with(ended.err, "visible voxels").size() == 2);
    CHECK(lines_with(ended.err, "2 frames, median").size() == 1);
  }
  const Ended timed = run_program({"render", files.volume(), "--stats", "-", "--size", "32"});
  CHECK(timed.code == 0);
  CHECK(json::parse(timed.out).size() == 1);
  CHECK_FALSE(fs::exists("-"));
}

TEST_CASE("--stats table, or a .txt, says by rank who worked and who waited", "[mpi]") {
  const Workshop files("ball", "20", {"--size", "32"});
  const Ended two =
      files.render("x.png", {"--gps", "2", "--renderers", "1", "--orbit", "2", "--stats", "table"}, 3);
  CHECK_THAT(two.out, Contains("2 frames, sums") && Contains("busy") && Contains("waiting") &&
                          Contains("received MB") && Contains("blocks sent"));
  CHECK(lines_with(two.out, "GP ").size() == 2);
  CHECK(lines_with(two.out, "Renderer 0").size() == 1);
  const std::string file = files / "stats.txt";
  files.render("x.png", {"--quality", "paper", "--stats", file});
  CHECK_THAT(read_text(file), Contains("1 frame, sums") && Contains("splats drawn"));
  CHECK_FALSE(fs::exists("table"));
}

TEST_CASE("a timeline and a transfer function can go to stdout", "[mpi]") {
  const Workshop files("ball", "20", {"--size", "32"});
  const Ended trace = files.render("x.png", {"--trace", "-"});
  CHECK(json::parse(trace.out).contains("traceEvents"));
  const Ended function = files.render("x.png", {"--tf-out", "-"});
  CHECK(json::parse(function.out).at(0).contains("RGBPoints"));
  const Ended truth = succeeded(
      run_program({"reference", files.volume(), "-o", files / "t.exr", "--size", "8", "--tf-out", "-"}));
  CHECK(json::parse(truth.out).at(0).contains("RGBPoints"));
}

TEST_CASE("reference names the options that change nothing in its truth", "[mpi]") {
  const Workshop files("ball", "20", {"--size", "32"});
  const auto warned = [&](const Words& more) {
    const Words words{"reference", files.volume(), "-o", files / "t.exr", "--size", "8"};
    return lines_with(succeeded(run_program(joined(words, more))).err, "warning");
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

TEST_CASE("a stdout that is full fails the run") {
  const Workshop files("ball", "20", {"--size", "32"});
  for (const auto& arguments : std::vector<std::vector<std::string>>{
           {"info", files.volume()},
           {"--man"},
           {"--completion", "bash"},
           {"--version"},
           {"synth", "--list"},
           {"render", files.volume(), "--stats", "-", "--size", "32"},
           {"render", files.volume(), "-o", files / "x.png", "--size", "32"}}) {
    CHECK(run_redirected(arguments, ">/dev/full 2>" + quoted(files / "err")) == 3);
    const std::string said = read_text(files / "err");
    CHECK_THAT(said, Catch::Matchers::Contains("standard output cannot be written"));
    CHECK(said.find("report") == std::string::npos);
  }
}

TEST_CASE("a closed stdout does not put its lines into the files that are opened instead") {
  const Workshop files("ball", "20", {"--size", "32"});
  const std::string with = files / "with.json", without = files / "without.json";
  const auto arguments = [&](const std::string& file) {
    return std::vector<std::string>{"render",   files.volume(), "--size", "32",
                                    "--tf-out", file,           "-o",     file + ".png"};
  };
  REQUIRE(run_program(arguments(with)).code == 0);
  CHECK(run_redirected(arguments(without), ">&- 2>&- <&-") == 0);
  CHECK(read_text(with) == read_text(without));
  CHECK(read_text(with + ".png") == read_text(without + ".png"));
}
