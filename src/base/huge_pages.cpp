#include "base/huge_pages.hpp"

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <memory>

namespace ringsplat {

void prefer_huge_pages(void* memory, std::size_t bytes) {
#ifdef MADV_HUGEPAGE
  constexpr std::size_t page = std::size_t{1} << 21;
  void* aligned = memory;
  if (std::align(page, page, aligned, bytes) != nullptr) madvise(aligned, bytes, MADV_HUGEPAGE);
#else
  static_cast<void>(memory);
  static_cast<void>(bytes);
#endif
}

void prefer_huge_pages_in_heap() {
#ifdef __GLIBC__
  constexpr int megabyte = 1 << 20, ahead = 256 * megabyte, largest_in_heap = 32 * megabyte;
  // The heap grows in large steps, so that one hint covers each, and never shrinks.
  if (mallopt(M_TOP_PAD, ahead) == 0 || mallopt(M_MMAP_THRESHOLD, largest_in_heap) == 0 ||
      mallopt(M_TRIM_THRESHOLD, 2 * ahead) == 0)
    return;
  const auto before = reinterpret_cast<std::uintptr_t>(sbrk(0));
  void* volatile block = std::malloc(largest_in_heap - megabyte);
  std::free(block);
  const auto after = reinterpret_cast<std::uintptr_t>(sbrk(0));
  if (after > before) prefer_huge_pages(reinterpret_cast<void*>(before), after - before);
#endif
}

}  // namespace ringsplat
