#include <fmt/format.h>
#include <sys/resource.h>

#include <string>

#include "base/input_file.hpp"
#include "base/memory_file.hpp"
#include "base/output_file.hpp"
#include "base/text.hpp"
#include "images/image_file.hpp"
#include "images/image_library.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

RunError failed(const std::string& path, const std::string& why, const std::string& hint) {
  return {fmt::format("{} cannot be written: {}", path, detail::one_line(why)), hint};
}

/// Memory does not run out like a disk, but the file size limit applies to it, too, and writers by name do
/// not notice what it cuts off. No writer adds more at once than the image and its header.
bool may_be_cut(std::uint64_t written, const ImageData& image) {
  constexpr std::uint64_t largest_sample = 8, header = 1 << 16;
  const std::uint64_t at_once = largest_sample * std::uint64_t(image.width) * std::uint64_t(image.height) *
                                    std::uint64_t(image.channels) +
                                header;
  rlimit limit{};
  const bool limited = getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
  return limited && written + at_once > limit.rlim_cur;
}

/// `path` names the format, and the file to people.
Bytes file_bytes(const std::string& path, const ImageData& image) {
  Bytes bytes;
  const detail::MemoryFile spare;
  const std::string problem = image_library().write(path, image, spare.path().string(), bytes);
  if (!problem.empty()) throw failed(path, problem, problem == no_memory ? "ask for a smaller picture" : "");
  if (!bytes.empty()) return bytes;
  const detail::InputFile written(spare.path());
  if (may_be_cut(written.size(), image))
    throw failed(path, "it is too near to the limit of files' sizes",
                 "raise ulimit -f, or write a .png or .exr");
  bytes.resize(written.size());
  written.read(0, bytes);
  return bytes;
}

}  // namespace

void write_image_file(const std::filesystem::path& path, const ImageData& image) {
  OutputFile file(path);
  file.write(file_bytes(path.string(), image));
  file.commit();
}

Bytes image_file_bytes(const std::string& ending, const ImageData& image) {
  return file_bytes("picture" + ending, image);
}

}  // namespace ringsplat
