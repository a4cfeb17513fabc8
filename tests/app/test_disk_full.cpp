#include <map>

#include "app/workshop.hpp"
#include "support/catch.hpp"

using namespace ringsplat::app_test;

namespace {

using Files = std::map<std::string, std::string>;

/// A folder's files, hidden ones included.
Files files_of(const fs::path& folder) {
  Files files;
  for (const auto& entry : fs::directory_iterator(folder))
    files[entry.path().filename().string()] = read_text(entry.path());
  return files;
}

/// Runs the program with a limit on file sizes. Its output goes through a pipe, which has no limit.
Ended run_limited(const Words& arguments, std::uintmax_t bytes) {
  const TemporaryFolder said;
  std::string command = "{ timeout -k 2 60 prlimit --fsize=" + std::to_string(bytes) + " " +
                        command_of(RINGSPLAT_PROGRAM, arguments);
  command += " 2>&1 >/dev/null; echo $? >" + quoted(said / "code") + "; } | cat >" + quoted(said / "err");
  REQUIRE(std::system(command.c_str()) == 0);
  Ended ended;
  ended.code = std::stoi(read_text(said / "code"));
  ended.err = read_text(said / "err");
  return ended;
}

struct Written {
  Words arguments;
  std::string file;  ///< the file without room
};

/// Commands write into its folder out; their inputs lie beside it.
struct Scene : Workshop {
  Scene() : Workshop("ball", "20", {"--size", "64"}) {
    fs::create_directory(out());
    render("a.png");
    render("b.png", {"--azimuth", "30"});
  }
  fs::path out() const { return path() / "out"; }
};

/// Every file that the program writes, each with a command that runs out of room for it.
std::vector<Written> all_that_is_written(const Scene& s) {
  const auto out = [&](const std::string& name) { return (s.out() / name).string(); };
  const auto render = [&](const std::string& file, const Words& more) {
    return Written{joined({"render", s.volume(), "--size", "64"}, more), file};
  };
  const auto small = [&](const std::string& option, const std::string& file) {
    return Written{{"render", s.volume(), "--size", "8", "-o", out("small.tga"), option, out(file)}, file};
  };
  const auto synth = [&](const std::string& name, const std::string& file, const Words& more = {}) {
    return Written{joined({"synth", "ball", "--dims", "20", "-o", out(name)}, more), file};
  };
  // Of pictures any byte of any format is left out in images/test_image_file.cpp.
  return {render("p.png", {"-o", out("p.png")}),
          render("p-0001.exr", {"-o", out("p.exr"), "--orbit", "2"}),
          small("--stats", "s.json"),
          small("--trace", "t.json"),
          small("--tf-out", "f.json"),
          {{"reference", s.volume(), "--size", "8", "-o", out("r.exr")}, "r.exr"},
          {{"compare", s / "a.png", s / "b.png", "--diff", out("d.png")}, "d.png"},
          synth("v.nrrd", "v.nrrd"),
          synth("v.nrrd", "v.nrrd", {"--no-compression"}),
          synth("v.nhdr", "v.raw"),
          synth("v.mhd", "v.raw"),
          synth("v.raw", "v_20x20x20_uint8.raw")};
}

}  // namespace

TEST_CASE("no room for a file ends the run with a message, and what was there stays", "[mpi]") {
  const Scene scene;
  for (const Written& written : all_that_is_written(scene)) {
    CAPTURE(written.arguments, written.file);
    succeeded(run_program(written.arguments));
    const Files whole = files_of(scene.out());
    for (const auto& [name, text] : whole) write_text(scene.out() / name, "old " + name);
    const Files old = files_of(scene.out());
    const auto bytes = whole.at(written.file).size();
    REQUIRE(bytes > 100);
    // Measured seconds vary in their number of digits.
    const bool measured = fs::path(written.file).extension() == ".json";
    std::vector<std::uintmax_t> limits{measured ? bytes * 7 / 8 : bytes - 1};
    if (written.file.find("p.") == 0) limits.push_back(0);
    for (const std::uintmax_t most : limits) {
      CAPTURE(most, bytes);
      const Ended failed = run_limited(written.arguments, most);
      INFO(failed.err);
      CHECK(failed.code == 3);
      CHECK(lines_with(failed.err, "").size() == 1);
      CHECK(lines_with(failed.err, "cannot be written: ").size() == 1);
      const Files left = files_of(scene.out());
      CHECK(left.size() == old.size());
      CHECK(left.at(written.file) == old.at(written.file));
      for (const auto& [name, text] : left) {
        INFO(name);
        const bool old_or_whole = text == old.at(name) || text.size() >= whole.at(name).size() / 2;
        CHECK(old_or_whole);
      }
      // In an orbit another picture may be the first without room.
      const fs::path named =
          written.file.find("-0001.") == std::string::npos ? scene.out() / written.file : scene.out();
      if (most > 0) CHECK(failed.err.find(named.string()) != std::string::npos);
    }
    for (const auto& [name, text] : whole) fs::remove(scene.out() / name);
  }
}
