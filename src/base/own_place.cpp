#include "base/own_place.hpp"

#include <dlfcn.h>
#include <link.h>

#include <cstddef>
#include <system_error>

namespace ringsplat {
namespace {

/// Null where it is unknown.
link_map* own_object() {
  link_map* self = nullptr;
#ifdef __GLIBC__
  Dl_info ignored;
  if (dladdr1(reinterpret_cast<void*>(&own_object), &ignored, reinterpret_cast<void**>(&self),
              RTLD_DL_LINKMAP) == 0)
    return nullptr;
#endif
  return self;
}

}  // namespace

std::filesystem::path own_folder() {
  const link_map* const self = own_object();
  const bool is_library = self != nullptr && self->l_name != nullptr && *self->l_name != '\0';
  std::error_code unknown;
  return (is_library ? std::filesystem::path(self->l_name)
                     : std::filesystem::read_symlink("/proc/self/exe", unknown))
      .parent_path();
}

std::vector<std::filesystem::path> own_search_path() {
  std::vector<std::filesystem::path> folders;
#ifdef __GLIBC__
  link_map* const self = own_object();
  Dl_serinfo size;
  if (self == nullptr || dlinfo(self, RTLD_DI_SERINFOSIZE, &size) != 0) return folders;
  std::vector<std::max_align_t> memory(size.dls_size / sizeof(std::max_align_t) + 1);
  auto* const path = reinterpret_cast<Dl_serinfo*>(memory.data());
  path->dls_size = size.dls_size;
  path->dls_cnt = size.dls_cnt;
  if (dlinfo(self, RTLD_DI_SERINFO, path) != 0) return folders;
  for (unsigned k = 0; k < path->dls_cnt; ++k) folders.emplace_back(path->dls_serpath[k].dls_name);
#endif
  return folders;
}

}  // namespace ringsplat
