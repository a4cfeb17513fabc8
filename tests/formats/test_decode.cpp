// What becomes of files when the program that decodes them for this process fails.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>

#include "formats/decode/program.hpp"
#include "formats/hdf5_files.hpp"
#include "ringsplat/formats/open.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace files;
using Catch::Matchers::Contains;
using detail::DecodeProgram;

namespace {

/// Compressed, so that this process cannot read it itself.
fs::path packed_file(const Folder& folder, const char* name = "packed.h5") {
  return write_hdf5(folder / name,
                    {Hdf5{.chunk = {1, ny, nx}, .creation = [](hid_t id) { H5Pset_deflate(id, 6); }}});
}

std::string read_complaint(VolumeSource& source) {
  return message_of([&] { read_all(source); });
}

/// The value behind `name` in /proc/PID/FILE.
std::string said_of(pid_t process, const std::string& file, const std::string& name) {
  std::ifstream lines("/proc/" + std::to_string(process) + "/" + file);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(name)) return line.substr(name.size());
  return {};
}

bool lives(pid_t process) {
  const auto state = said_of(process, "status", "State:");
  return !state.empty() && state.find('Z') == std::string::npos;
}

}  // namespace

TEST_CASE("a program that is killed while it decodes is an error that names the file") {
  const Folder folder;
  const auto source = open_volume(packed_file(folder)), other = open_volume(packed_file(folder, "other.h5"));
  const auto voxels = read_all(*source);
  ::kill(DecodeProgram::running()->id(), SIGKILL);
  CHECK_THAT(read_complaint(*source),
             Contains("packed.h5: HDF5 crashes on it (Killed)") && Contains("hint: "));
  // Then there is another program.
  CHECK(read_all(*other) == voxels);
  CHECK(read_all(*source) == voxels);
}

TEST_CASE("a program that uses up its time is an error that names the file") {
  const Folder folder;
  const auto source = open_volume(packed_file(folder));
  const auto program = DecodeProgram::running()->id();
  const auto limit = said_of(program, "limits", "Max cpu time");
  CHECK_THAT(limit.substr(0, limit.find("seconds")),
             Contains("unlimited") && !Contains("unlimited           un"));
  CHECK_THAT(said_of(program, "limits", "Max core file size"), Contains(" 0 "));
  ::kill(program, SIGXCPU);
  CHECK_THAT(read_complaint(*source), Contains("packed.h5: HDF5 comes to no end with it"));
}

TEST_CASE("a program that has no memory is an error that names the file") {
  const Folder folder;
  const auto source = open_volume(packed_file(folder));
  const auto program = DecodeProgram::running()->id();
  const rlimit none{1, 1};
  REQUIRE(::prlimit(program, RLIMIT_AS, &none, nullptr) == 0);
  CHECK_THAT(read_complaint(*source), Contains("packed.h5"));
  ::kill(program, SIGKILL);
  CHECK_THAT(read_complaint(*source), Contains("packed.h5"));
  CHECK(read_all(*source).size() == samples<short>().size());
}

TEST_CASE("the program of a process ends with it, and copies of a process have their own") {
  const Folder folder;
  const auto file = packed_file(folder);
  const auto here = open_volume(file);
  const auto before = DecodeProgram::running()->id();
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const pid_t copy = ::fork();
  if (copy == 0) {
    pid_t program = 0;
    try {
      read_all(*here);
      program = DecodeProgram::running()->id();
    } catch (const std::exception&) {
    }
    _exit(::write(ends[1], &program, sizeof program) == sizeof program ? 0 : 1);
  }
  pid_t program = 0;
  REQUIRE(::read(ends[0], &program, sizeof program) == sizeof program);
  int status = 0;
  REQUIRE(::waitpid(copy, &status, 0) == copy);
  for (const int end : ends) ::close(end);
  CHECK(program > 0);
  CHECK(program != before);
  while (lives(program)) ::usleep(1000);
  CHECK(DecodeProgram::running()->id() == before);
  CHECK(read_all(*here).size() == samples<short>().size());
}
