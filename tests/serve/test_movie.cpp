#include "serve/movie.hpp"

#include <cstdlib>
#include <fstream>
#include <thread>

#include "base/child_program.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/temporary_folder.hpp"

using namespace ringsplat;
using namespace ringsplat::serve;
using namespace std::chrono_literals;
using support::TemporaryFolder;

namespace {

const std::filesystem::path shell = "/bin/sh";

Movie::Clock::time_point in(std::chrono::milliseconds time) { return Movie::Clock::now() + time; }

std::filesystem::path script(const TemporaryFolder& folder, const std::string& text) {
  const std::filesystem::path file = folder / "ffmpeg";
  std::ofstream(file) << "#!/bin/sh\n" << text << "\n";
  std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  return file;
}

/// An environment variable with another value while this exists.
class Environment {
 public:
  Environment(const char* name, const std::string& value)
      : name_(name), before_(std::getenv(name) == nullptr ? "" : std::getenv(name)) {
    setenv(name, value.c_str(), 1);
  }
  ~Environment() { before_.empty() ? unsetenv(name_) : setenv(name_, before_.c_str(), 1); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
  std::string before_;
};

}  // namespace

TEST_CASE("A program is looked for in the absolute folders of PATH") {
  const TemporaryFolder folder;
  const auto program = script(folder, "exit 0");
  std::ofstream(folder / "text") << "no program";
  const Environment path("PATH", ".::/nowhere:" + folder.path().string());
  CHECK(find_program("ffmpeg") == program);
  CHECK_FALSE(find_program("text"));
  CHECK_FALSE(find_program("no such program"));
}

TEST_CASE(
    "A program runs in its folder, without the descriptors of this process, and its exit code comes back") {
  const TemporaryFolder folder;
  std::atomic<bool> cancelled = false;
  const std::ofstream open(folder / "open");
  CHECK(run_program(shell, {"-c", "ls /proc/self/fd | wc -l > count; exit 7"}, folder.path(), in(60s),
                    cancelled) == 7);
  int descriptors = 0;
  std::ifstream(folder / "count") >> descriptors;
  CHECK(descriptors == 4);  // three, and that of the folder that ls reads
  CHECK(run_program(shell, {"-c", "kill -9 $$"}, folder.path(), in(60s), cancelled) == 128 + 9);
  CHECK_THROWS_AS(run_program("/no/such/program", {}, folder.path(), in(60s), cancelled), RunError);
}

TEST_CASE("A program that takes too long or is cancelled is killed with what it started") {
  const TemporaryFolder folder;
  std::atomic<bool> cancelled = false;
  const std::vector<std::string> hangs{"-c", "(sleep 2; touch alive) & wait"};
  CHECK_FALSE(run_program(shell, hangs, folder.path(), in(50ms), cancelled));
  cancelled = true;
  CHECK_FALSE(run_program(shell, hangs, folder.path(), in(60s), cancelled));
  std::this_thread::sleep_for(2500ms);
  CHECK_FALSE(std::filesystem::exists(folder / "alive"));
}

TEST_CASE("A movie's folder is private, and gone with it whatever ffmpeg did") {
  const TemporaryFolder folder;
  const auto ends = GENERATE(values<std::string>({"exit 1", "exit 0", ": > movie.mp4", "mkdir movie.mp4",
                                                  "printf x > movie.mp4", "sleep 60", "kill -9 $$"}));
  CAPTURE(ends);
  std::filesystem::path frames;
  {
    Movie movie(script(folder, ends), {1, 25, 3, 3});
    frames = movie.folder();
    CHECK(std::filesystem::status(frames).permissions() == std::filesystem::perms::owner_all);
    movie.add(0, Bytes(10));
    CHECK(std::filesystem::file_size(frames / "00000.png") == 10);
    if (ends.starts_with("printf"))
      CHECK(movie.encode(in(60s)) == "x");
    else
      CHECK_THROWS_AS(movie.encode(in(300ms)), RunError);
  }
  CHECK_FALSE(std::filesystem::exists(frames));
}

TEST_CASE("A movie cannot be begun where there is no temporary folder") {
  const Environment nowhere("TMPDIR", "/no/such/folder");
  CHECK_THROWS_AS(Movie("/bin/true", {1, 25, 3, 3}), RunError);
}
