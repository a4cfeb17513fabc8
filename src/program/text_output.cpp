#include "program/text_output.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "ringsplat/base/error.hpp"

namespace ringsplat::app {
namespace {

namespace fs = std::filesystem;

bool is_same(const std::string& a, const std::string& b) {
  if (a.empty() || b.empty()) return false;
  if (is_stdout(a) || is_stdout(b)) return a == b;
  std::error_code error;
  if (fs::equivalent(a, b, error)) return true;
  const fs::path one = fs::weakly_canonical(a, error), other = fs::weakly_canonical(b, error);
  return !one.empty() && one == other;
}

/// Whether `file` is in `folder`, most of whose files have its ending: the slices of a volume.
bool is_among(const fs::path& file, const fs::path& folder) {
  std::error_code error;
  if (file.empty() || !fs::is_directory(folder, error) ||
      !fs::equivalent(fs::absolute(file).parent_path(), folder, error))
    return false;
  int alike = 0, files = 0;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    alike += entry.path().extension() == file.extension();
    ++files;
  }
  return alike > files / 2;
}

}  // namespace

void write_text_output(const std::string& file, const std::string& text) {
  if (!is_stdout(file)) {
    write_text(file, text);
    return;
  }
  std::fwrite(text.data(), 1, text.size(), stdout);
  flush_stdout();
}

void flush_stdout() {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return;
  throw RunError(fmt::format("standard output cannot be written{}{}", errno == 0 ? "" : ": ",
                             errno == 0 ? "" : std::strerror(errno)),
                 "is the disk full?");
}

void refuse_clashes(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs) {
  for (std::size_t k = 0; k < outputs.size(); ++k) {
    const NamedFile& output = outputs[k];
    for (std::size_t other = 0; other < k; ++other)
      if (is_same(output.file, outputs[other].file))
        throw InputError(fmt::format("{} and {} name the same file", outputs[other].option, output.option),
                         "give each a file of its own");
    for (const NamedFile& input : inputs) {
      if (is_stdout(input.file)) continue;
      if (is_same(output.file, input.file))
        throw InputError(
            fmt::format("{} {} would replace {}, which is read", output.option, output.file, input.option),
            "write into another file");
      if (is_among(output.file, input.file))
        throw InputError(fmt::format("{} {} would lie among the slices of {}, {}", output.option, output.file,
                                     input.option, input.file),
                         "write into another folder");
    }
  }
}

}  // namespace ringsplat::app
