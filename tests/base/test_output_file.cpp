#include "base/output_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>

#include "base/log.hpp"
#include "ringsplat/base/error.hpp"
#include "support/catch.hpp"
#include "support/file_size_limit.hpp"
#include "support/temporary_folder.hpp"

using namespace ringsplat;
using support::files_in;
using support::FileSizeLimit;
using support::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void make(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }

/// Runs `work` in a child process, which then ends at once. Returns the child's number.
pid_t in_a_child(const std::function<void()>& work) {
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    work();
    _exit(0);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  return child;
}

std::string only_name_in(const fs::path& folder) {
  REQUIRE(files_in(folder) == 1);
  return fs::directory_iterator(folder)->path().filename().string();
}

/// Makes a file two minutes old.
void age(const fs::path& file) {
  fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::minutes(2));
}

}  // namespace

TEST_CASE("a file gets its name when all of it is on the disk") {
  const TemporaryFolder folder;
  make(folder / "a.txt", "old");
  {
    OutputFile file(folder / "a.txt");
    file.write("new ");
    CHECK(files_in(folder.path()) <= 2);  // a disk may have no files without names
    file.write("text");
    file.secure();
    CHECK(text_of(folder / "a.txt") == "old");
    file.commit();
  }
  CHECK(text_of(folder / "a.txt") == "new text");
  CHECK(only_name_in(folder.path()) == "a.txt");
}

TEST_CASE("a file is written where the user's links lead, and takes the place of others'") {
  const TemporaryFolder folder, elsewhere;
  make(elsewhere / "there.txt", "old");
  fs::create_symlink(elsewhere / "there.txt", folder / "a.txt");
  fs::create_symlink("a.txt", folder / "b.txt");
  fs::create_symlink(elsewhere / "new.txt", folder / "c.txt");
  for (const char* name : {"a.txt", "b.txt", "c.txt"}) {
    check_can_write(folder / name, "-o");
    write_text(folder / name, name);
    CHECK(fs::is_symlink(folder / name));
    CHECK(text_of(folder / name) == name);
  }
  CHECK(text_of(elsewhere / "there.txt") == "b.txt");
  CHECK(text_of(elsewhere / "new.txt") == "c.txt");
  CHECK(files_in(elsewhere.path()) == 2);
  constexpr uid_t somebody = 12345;
  if (lchown((folder / "a.txt").c_str(), somebody, gid_t(-1)) != 0) return;  // only root may
  std::vector<std::string> said;
  set_log_sink([&](LogLevel, const std::string& text) { said.push_back(text); });
  write_text(folder / "a.txt", "mine");
  set_log_sink({});
  CHECK_FALSE(fs::is_symlink(folder / "a.txt"));
  CHECK(text_of(elsewhere / "there.txt") == "b.txt");
  REQUIRE(said.size() == 1);
  CHECK(said.front().find("is a link") != std::string::npos);
}

TEST_CASE("a file that is given up leaves nothing") {
  const TemporaryFolder folder;
  make(folder / "a.txt", "old");
  { OutputFile(folder / "a.txt").write("new"); }
  CHECK(only_name_in(folder.path()) == "a.txt");
  CHECK(text_of(folder / "a.txt") == "old");
}

TEST_CASE("pieces of any size follow each other") {
  const TemporaryFolder folder;
  constexpr std::size_t large = (std::size_t{3} << 20) + 5;
  std::string expected;
  OutputFile file(folder / "a");
  for (std::size_t k = 0; k < 400; ++k) {
    const std::string part(k % 50 == 7 ? large : k * 7919 % 5000, char('a' + k % 26));
    file.write(part);
    expected += part;
    REQUIRE(file.size() == expected.size());
  }
  file.commit();
  const bool same = text_of(folder / "a") == expected;
  CHECK(same);
}

TEST_CASE("a text that finds no room for any one of its bytes is an error and leaves the old one alone") {
  const TemporaryFolder folder;
  make(folder / "a.txt", "old");
  const std::string text = "twelve bytes";
  for (std::size_t most = 0; most < text.size(); ++most) {
    const FileSizeLimit limit(most);
    CHECK_THROWS_AS(write_text(folder / "a.txt", text), RunError);
    CHECK(text_of(folder / "a.txt") == "old");
    CHECK(files_in(folder.path()) == 1);
  }
  const FileSizeLimit limit(text.size());
  write_text(folder / "a.txt", text);
  CHECK(text_of(folder / "a.txt") == text);
}

TEST_CASE("a name of any length that the disk allows can be written") {
  const TemporaryFolder folder;
  const std::string name = std::string(251, 'n') + ".txt";
  write_text(folder / name, "text");
  CHECK(only_name_in(folder.path()) == name);
}

TEST_CASE("where no file can be made is said before, and devices stay devices") {
  const TemporaryFolder folder;
  CHECK_NOTHROW(check_can_write(folder / "a.txt", "-o"));
  CHECK(files_in(folder.path()) == 0);
  for (const std::string& path :
       {folder / "missing/a.txt", folder.path().string(), folder / "", std::string("/dev/null")}) {
    INFO(path);
    CHECK_THROWS_AS(check_can_write(path, "-o"), InputError);
    CHECK_THROWS_AS(write_text(path, "text"), RunError);
  }
  CHECK(fs::is_character_file("/dev/null"));
}

TEST_CASE(
    "what a killed process leaves, where it leaves anything, goes when another writes into the folder") {
  const TemporaryFolder folder;
  in_a_child([&] {
    OutputFile file(folder / "x.png");
    file.write("some of it");
    raise(SIGKILL);
  });
  for (const auto& left : fs::directory_iterator(folder.path())) age(left.path());
  in_a_child([&] { write_text(folder / "y.txt", "text"); });
  CHECK(only_name_in(folder.path()) == "y.txt");
}

TEST_CASE("only old hidden files that nobody writes are removed") {
  const TemporaryFolder folder;
  const std::string stale = folder / ".ringsplat_123-0", young = folder / ".ringsplat_124-0",
                    locked = folder / ".ringsplat_125-0";
  const std::vector<std::string> others{".ringsplat_x", ".ringsplat", "ringsplat_126-0", ".x_127-0"};
  for (const std::string& file : {stale, young, locked}) make(file, "some of it");
  for (const std::string& other : others) {
    make(folder / other, "not ours");
    age(folder / other);
  }
  fs::create_directory(folder / ".ringsplat_128-0");
  fs::create_symlink(folder / others[0], folder / ".ringsplat_129-0");
  age(stale);
  age(locked);
  const int descriptor = open(locked.c_str(), O_RDONLY | O_CLOEXEC);
  REQUIRE(flock(descriptor, LOCK_SH) == 0);

  in_a_child([&] { write_text(folder / "y.txt", "text"); });
  CHECK_FALSE(fs::exists(stale));
  CHECK(files_in(folder.path()) == others.size() + 5);
  close(descriptor);
  in_a_child([&] { write_text(folder / "y.txt", "text"); });
  CHECK_FALSE(fs::exists(locked));
  CHECK(files_in(folder.path()) == others.size() + 4);
}

TEST_CASE("many files can be written at once") {
  const TemporaryFolder folder;
  std::vector<std::unique_ptr<OutputFile>> files;
  for (int k = 0; k < 100; ++k) {
    files.push_back(std::make_unique<OutputFile>(folder / std::to_string(k)));
    files.back()->write("text");
  }
  for (const auto& file : files) file->commit();
  files.clear();
  CHECK(files_in(folder.path()) == 100);
}
