#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <exception>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "base/memory_file.hpp"
#include "base/output_file.hpp"
#include "images/image_file.hpp"
#include "images/image_library.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

RunError failed(const std::filesystem::path& path, std::string why, const std::string& hint = {}) {
  std::replace(why.begin(), why.end(), '\n', ' ');
  return {fmt::format("{} cannot be written: {}", path.string(), why), hint};
}

/// Keeps the exception of a failed write until the library returns: none may pass through the library.
class FileSink final : public ImageSink {
 public:
  explicit FileSink(const std::filesystem::path& path) : file(path) {}

  bool write_at(std::uint64_t offset, const void* bytes, std::size_t count) override {
    if (failure) return false;
    try {
      file.write_at(offset, std::span(static_cast<const std::byte*>(bytes), count));
    } catch (...) {
      failure = std::current_exception();
    }
    return !failure;
  }
  std::uint64_t size() const override { return file.size(); }
  std::string name_to_write_by() override try {
    if (!by_name) by_name.emplace();
    return by_name->path().string();
  } catch (const RunError&) {
    return {};
  }

  OutputFile file;
  std::optional<detail::MemoryFile> by_name;
  std::exception_ptr failure;
};

class MemorySink final : public ImageSink {
 public:
  bool write_at(std::uint64_t offset, const void* from, std::size_t count) override try {
    if (offset + count > bytes.size()) {
      bytes.reserve(std::max(bytes.capacity(), bytes.size() + bytes.size() / 2));
      bytes.resize(offset + count);
    }
    std::memcpy(bytes.data() + offset, from, count);
    return true;
  } catch (const std::bad_alloc&) {
    no_memory = true;
    return false;
  }
  std::uint64_t size() const override { return bytes.size(); }
  /// Formats of this kind are not asked for.
  std::string name_to_write_by() override { return {}; }

  Bytes bytes;
  bool no_memory = false;
};

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

}  // namespace

void write_image_file(const std::filesystem::path& path, const ImageData& image) {
  FileSink sink(path);
  const std::string problem = image_library().write(path.string(), image, sink);
  if (sink.failure) std::rethrow_exception(sink.failure);
  if (!problem.empty()) throw failed(path, problem);
  if (sink.by_name) {
    if (may_be_cut(sink.by_name->size(), image))
      throw failed(path, "it is too near to the limit of files' sizes",
                   "raise ulimit -f, or write a .png or .exr");
    sink.by_name->read([&sink](std::span<const std::byte> part) { sink.file.write(part); });
  }
  sink.file.commit();
}

Bytes image_file_bytes(const std::string& ending, const ImageData& image) {
  MemorySink sink;
  const std::string name = "picture" + ending, problem = image_library().write(name, image, sink);
  if (sink.no_memory) throw failed(name, "there is not enough memory", "ask for a smaller picture");
  if (!problem.empty()) throw failed(name, problem);
  return std::move(sink.bytes);
}

}  // namespace ringsplat
