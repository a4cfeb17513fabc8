#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>

#include "formats/files.hpp"
#include "support/catch.hpp"
#include "support/message_of.hpp"

using namespace files;

namespace {

std::vector<fs::path> kept_files() {
  std::vector<fs::path> list;
  for (const auto& entry : fs::directory_iterator(RINGSPLAT_TEST_DATA "/bad")) list.push_back(entry.path());
  std::sort(list.begin(), list.end());
  return list;
}

/// In a folder of its own, since DICOM files together would be a series.
std::string complaint_about(const fs::path& file) {
  const Folder folder;
  const auto copy = folder / file.filename().string();
  fs::copy_file(file, copy);
  return message_of([&] { read_all(*open_volume(copy)); });
}

}  // namespace

TEST_CASE("files that made a reader crash, hang or take all memory are refused", "[bad]") {
  REQUIRE(kept_files().size() >= 13);
  for (const auto& path : kept_files()) {
    const auto text = complaint_about(path);
    CAPTURE(path.string(), text);
    CHECK(says(text, path.filename().string()));
    CHECK(says(text, "hint: "));
  }
}

TEST_CASE("refusing a small file takes little memory", "[bad]") {
  for (const auto& path : kept_files()) {
    CAPTURE(path.string());
    struct rusage before {};
    ::getrusage(RUSAGE_SELF, &before);
    const auto child = ::fork();
    if (child == 0) ::_exit(complaint_about(path).empty() ? 1 : 0);
    int status = 0;
    struct rusage used {};
    REQUIRE(::wait4(child, &status, 0, &used) == child);
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 0);
    constexpr long most = 200 * 1024;  // KiB, beside what this process had before
    CHECK(used.ru_maxrss < before.ru_maxrss + most);
  }
}
