#include "images/image_file.hpp"

#include <dlfcn.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>

#include "base/input_file.hpp"
#include "base/lack_of_memory.hpp"
#include "base/process.hpp"
#include "base/text.hpp"
#include "images/image_library.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

/// Address space that OpenImageIO and what it links take while they are loaded, 480 MB, and some more.
/// log4cplus and OpenBLAS start threads then, and wait for ever where one cannot be started.
constexpr std::size_t loading_takes = std::size_t{512} << 20;

/// OpenBLAS, of which nothing here is used, would start a thread for each core.
constexpr const char* blas_threads = "OPENBLAS_NUM_THREADS";

/// Finds the library as if it had been linked; null where dlerror() says why not.
void* open_shared_library(const char* name) {
  // dlopen searches its caller's folders. With a sanitizer or a profiler in between the caller is not this
  // program.
  std::error_code ignored;
  for (const std::filesystem::path& folder : own_search_path())
    if (std::filesystem::exists(folder / name, ignored))
      return dlopen((folder / name).c_str(), RTLD_LAZY | RTLD_LOCAL);
  return dlopen(name, RTLD_LAZY | RTLD_LOCAL);
}

/// A file that exists in memory only and goes with the object; it has a name, for writers that want one.
struct MemoryFile {
  MemoryFile() {
    if (descriptor < 0)
      throw RunError(fmt::format("cannot make a file in memory: {}", std::strerror(errno)),
                     "free memory or raise its limits");
  }
  ~MemoryFile() { ::close(descriptor); }
  MemoryFile(const MemoryFile&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor); }

  const int descriptor = ::memfd_create("ringsplat", MFD_CLOEXEC);
};

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

}  // namespace

const ImageLibrary& image_library_of(const char* shared_library) {
  const auto failed = [&](const std::string& why) {
    return RunError(fmt::format("images can be neither read nor written: {}", why),
                    fmt::format("{} belongs in ringsplat's library folder: install again, or name its "
                                "folder in LD_LIBRARY_PATH",
                                shared_library));
  };
  if (!has_address_space(loading_takes)) throw std::bad_alloc();
  const bool is_set = std::getenv(blas_threads) != nullptr;
  setenv(blas_threads, "1", 0);
  // Never closed: objects that it made may live as long as the process.
  void* const library = open_shared_library(shared_library);
  const std::string problem = library == nullptr ? dlerror() : "";
  if (!is_set) unsetenv(blas_threads);
  const auto says = [&](const char* words) { return problem.find(words) != std::string::npos; };
  if (says("failed to map segment") || says("Cannot allocate memory") || says("cannot create"))
    throw std::bad_alloc();
  if (library == nullptr) throw failed(problem);
  void* const found = dlsym(library, "ringsplat_image_library");
  if (found == nullptr) throw failed(dlerror());
  return *reinterpret_cast<decltype(&ringsplat_image_library)>(found)();
}

const ImageLibrary& image_library() {
  static const ImageLibrary& loaded = image_library_of(RINGSPLAT_IMAGE_LIBRARY);
  return loaded;
}

std::shared_future<void> load_image_library(bool meanwhile) {
  using enum std::launch;
  // Not by the other thread, as this one may read its environment meanwhile.
  setenv(blas_threads, "1", 0);
  // What this thread takes of an address space that is limited may be missing while the library is loaded.
  const bool limited = !has_address_space(std::size_t{1} << 40);
  return std::async(meanwhile && !limited ? async | deferred : deferred,
                    [] {
                      try {
                        static_cast<void>(image_library());
                      } catch (const RunError& e) {
                        throw InputError(e.what());
                      }
                    })
      .share();
}

OpenedImageFile open_image_file(const std::filesystem::path& path) {
  return image_library().open(path.string());
}

Bytes image_file_bytes(const std::string& path, const ImageData& image) {
  Bytes bytes;
  const MemoryFile spare;
  const std::string problem = image_library().write(path, image, spare.path(), bytes);
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

}  // namespace ringsplat
