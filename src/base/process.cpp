#include "base/process.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace ringsplat {

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
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (!line.starts_with("0::/")) continue;
    auto group = std::filesystem::path("/sys/fs/cgroup") / line.substr(4);
    for (; group != "/sys/fs"; group = group.parent_path())
      if (double most = 0; std::ifstream(group / "memory.max") >> most) bytes = std::min(bytes, most);
  }
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

namespace {

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

/// The number of cores whose time this process's control group may use; infinite without a limit.
double cores_of_control_group() {
  std::string group;
  std::ifstream groups("/proc/self/cgroup");
  while (std::getline(groups, group) && !group.starts_with("0::")) continue;
  double quota = 0, period = 0;
  if (group.starts_with("0::") &&
      std::ifstream("/sys/fs/cgroup" + group.substr(3) + "/cpu.max") >> quota >> period && period > 0)
    return quota / period;
  return std::numeric_limits<double>::infinity();
}

}  // namespace

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
  const double most = std::ceil(cores_of_control_group());
  if (most < double(cores.size())) cores.resize(std::size_t(std::max(1.0, most)));
  return cores;
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
