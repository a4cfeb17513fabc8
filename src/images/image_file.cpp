#include "ringsplat/images/image_file.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include "images/image_library.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
namespace {

const ImageLibrary& library() {
  static const ImageLibrary& loaded = image_library_of(RINGSPLAT_IMAGE_LIBRARY);
  return loaded;
}

}  // namespace

const ImageLibrary& image_library_of(const char* shared_library) {
  const auto failed = [&] {
    const char* why = dlerror();
    return RunError(
        fmt::format("images can be neither read nor written: {}", why == nullptr ? shared_library : why),
        fmt::format("{} belongs in ringsplat's library folder: install again, or name its folder in "
                    "LD_LIBRARY_PATH",
                    shared_library));
  };
  // Found as if it had been linked. It stays: what it made may live as long as the process.
  void* const opened = dlopen(shared_library, RTLD_LAZY | RTLD_LOCAL);
  if (opened == nullptr) throw failed();
  void* const found = dlsym(opened, "ringsplat_image_library");
  if (found == nullptr) throw failed();
  return *reinterpret_cast<decltype(&ringsplat_image_library)>(found)();
}

OpenedImageFile open_image_file(const std::filesystem::path& path) { return library().open(path.string()); }

std::string write_image_file(const std::filesystem::path& path, const ImageData& image) {
  return library().write(path.string(), image);
}

}  // namespace ringsplat
