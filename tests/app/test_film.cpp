// -o FILM.mp4: what the program gives ffmpeg, and what it says where that fails.
#include "app/workshop.hpp"
#include "base/child_program.hpp"
#include "images/image_io.hpp"
#include "support/catch.hpp"

using namespace ringsplat;
using namespace ringsplat::app_test;
using Catch::Matchers::Contains;

namespace {

/// A volume, and a script that stands for ffmpeg and runs in the folder of the frames.
struct Studio {
  TemporaryFolder folder;
  std::string volume = folder / "jack_24x24x24_uint8.raw", film = folder / "film.mp4";
  Studio() {
    REQUIRE(run_program({"synth", "jack", "-o", folder / "jack.raw", "--dims", "24x24x24"}).code == 0);
    for (const char* name : {"bin", "kept", "tmp"}) fs::create_directory(folder / name);
  }
  void ffmpeg(const std::string& script) const {
    const fs::path program = folder / "bin/ffmpeg";
    write_text(program, "#!/bin/sh\n" + script);
    fs::permissions(program, fs::perms::owner_all);
  }
  /// With no program but the script in PATH, unless `path` says otherwise.
  Ended render(const std::vector<std::string>& more, int ranks = 0, const std::string& path = {}) const {
    std::vector<std::string> words;
    if (ranks > 0) words = {"-n", std::to_string(ranks), "/usr/bin/env"};
    words.push_back("PATH=" + (path.empty() ? folder / "bin" : path));  // a launcher prepends to its own
    words.insert(words.end(), {"TMPDIR=" + (folder / "tmp"), RINGSPLAT_PROGRAM, "render", volume, "-o", film,
                               "--size", "33x32", "--tf", "grey"});
    words.insert(words.end(), more.begin(), more.end());
    return run_command(command_of(ranks > 0 ? RINGSPLAT_MPIEXEC : "/usr/bin/env", words));
  }
  bool is_clean() const { return files_in(folder / "tmp") == 0 && !fs::exists(folder / "film-0000.png"); }
};

}  // namespace

TEST_CASE("a film has all views as opaque pictures, on one process and on ranks", "[mpi]") {
  const Studio studio;
  studio.ffmpeg("/bin/cp *.png " + studio.folder / "kept" + "; echo made > movie.mp4\n");
  for (const int ranks : {0, 3}) {
    fs::remove(studio.film);
    const Ended ended = succeeded(studio.render({"--orbit", "4", "--annotate"}, ranks));
    CHECK(read_text(studio.film) == "made\n");
    CHECK(lines_with(ended.out, studio.film).size() == 1);
    CHECK(files_in(studio.folder / "kept") == 4);
    const auto last = read_image(studio.folder / "kept/00003.png");
    CHECK(last.image.width == 33);
    CHECK_FALSE(last.has_alpha);
    CHECK(studio.is_clean());
  }
}

TEST_CASE("a film that fails leaves the file that had its name, and no frames", "[mpi]") {
  const Studio studio;
  write_text(studio.film, "before");
  studio.ffmpeg("exit 7\n");
  for (const int ranks : {0, 2}) {
    const Ended ended = studio.render({"--orbit", "2"}, ranks);
    CHECK(ended.code == 3);
    CHECK_THAT(ended.err, Contains("ffmpeg failed with exit code 7"));
    CHECK(read_text(studio.film) == "before");
    CHECK(studio.is_clean());
  }
}

TEST_CASE("what cannot be a film is refused before anything is drawn, and so is a missing ffmpeg") {
  const Studio studio;
  const auto refused = [&](const std::vector<std::string>& more, const std::string& said) {
    const Ended ended = studio.render(more);
    CHECK(ended.code == 2);
    CHECK_THAT(ended.err, Contains(said));
    CHECK_FALSE(fs::exists(studio.film));
  };
  refused({"--orbit", "2"}, "needs ffmpeg, and no folder in PATH has it; hint: install it");
  studio.ffmpeg("exit 0\n");
  refused({}, "one view is none; hint: turn around the volume with --orbit");
}

TEST_CASE("the ffmpeg that is installed makes a film that it can read", "[mpi]") {
  const auto ffmpeg = find_program("ffmpeg");
  if (!ffmpeg) {
    WARN("skipped: install ffmpeg");
    return;
  }
  const Studio studio;
  succeeded(studio.render({"--orbit", "5"}, 0, ffmpeg->parent_path()));
  CHECK(studio.is_clean());
  const Ended read =
      run_command(command_of(*ffmpeg, {"-v", "error", "-i", studio.film, studio.folder / "kept/%d.png"}));
  CHECK(read.code == 0);
  CHECK(files_in(studio.folder / "kept") == 5);
  CHECK(read_image(studio.folder / "kept/1.png").image.width == 34);
}
