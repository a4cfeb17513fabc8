#include "base/process.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <malloc.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <system_error>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace ringsplat {
namespace {

/// The folder of this process's control group (version 2), or that of all groups.
std::filesystem::path control_group() {
  const std::filesystem::path all = "/sys/fs/cgroup";
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);)
    if (line.starts_with("0::/")) return all / line.substr(4);
  return all;
}

/// Hardware threads that this process may run on.
std::vector<int> allowed_threads() {
  // The kernel refuses a set smaller than its own; this one is for 65,536 threads.
  std::vector<cpu_set_t> set(64);
  const std::size_t bytes = set.size() * sizeof(cpu_set_t);
  std::vector<int> threads;
  if (sched_getaffinity(0, bytes, set.data()) == 0)
    for (std::size_t thread = 0; thread < 8 * bytes; ++thread)
      if (CPU_ISSET_S(thread, bytes, set.data())) threads.push_back(int(thread));
  if (!threads.empty()) return threads;
  return {0};
}

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

std::uint64_t peak_memory_bytes() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024U;
}

std::string host_name() {
  std::array<char, HOST_NAME_MAX + 1> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

double machine_memory_bytes() {
  double bytes = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGE_SIZE));
  for (auto group = control_group(); group != "/sys/fs"; group = group.parent_path())
    if (double most = 0; std::ifstream(group / "memory.max") >> most) bytes = std::min(bytes, most);
  return bytes;
}

std::string clock_identity() {
  std::string boot;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), boot);
  return boot;
}

void keep_standard_descriptors() {
  // open() takes the lowest free number, so a descriptor above stderr's shows that all three are open.
  int descriptor = 0;
  do {
    descriptor = open("/dev/null", O_RDWR);
  } while (descriptor >= 0 && descriptor <= STDERR_FILENO);
  if (descriptor > STDERR_FILENO) close(descriptor);
}

std::vector<int> allowed_cores() {
  std::vector<int> cores;
  for (const int thread : allowed_threads()) {
    int first = thread;
    std::ifstream("/sys/devices/system/cpu/cpu" + std::to_string(thread) +
                  "/topology/thread_siblings_list") >>
        first;
    cores.push_back(first);
  }
  std::sort(cores.begin(), cores.end());
  cores.erase(std::unique(cores.begin(), cores.end()), cores.end());
  // The control group's processes may use so much time in so much time.
  double quota = 0, period = 0;
  if (std::ifstream(control_group() / "cpu.max") >> quota >> period && period > 0)
    cores.resize(std::size_t(std::clamp(std::ceil(quota / period), 1.0, double(cores.size()))));
  return cores;
}

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

void Unmap::operator()(std::byte* memory) const { munmap(memory, bytes); }

MappedMemory map_memory(std::size_t bytes) {
  void* const memory =
      mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return {static_cast<std::byte*>(memory), {bytes}};
}

void prefer_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#ifdef MADV_HUGEPAGE
  constexpr std::size_t page = std::size_t{1} << 21;
  void* aligned = memory;
  if (std::align(page, page, aligned, bytes) != nullptr) madvise(aligned, bytes, MADV_HUGEPAGE);
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

void flush_denormals() {
#if defined(__SSE2__)
  constexpr unsigned flushing = 0x8040;  // flush to zero, denormals are zero
  _mm_setcsr(_mm_getcsr() | flushing);
#elif defined(__aarch64__)
  std::uint64_t control = 0;
  asm volatile("mrs %0, fpcr" : "=r"(control));
  asm volatile("msr fpcr, %0" ::"r"(control | std::uint64_t{1} << 24));
#endif
}

PlainFloats::PlainFloats() {
  std::feholdexcept(&before_);
  std::fesetenv(FE_DFL_ENV);
}
PlainFloats::~PlainFloats() { std::fesetenv(&before_); }

}  // namespace ringsplat
