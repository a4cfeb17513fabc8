#include "base/process.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>

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

double machine_memory_bytes() { return double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGE_SIZE)); }

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
  // The kernel refuses a set smaller than its own and does not say how large its own is.
  for (int most = 1024; most <= 1 << 20; most *= 2) {
    const std::unique_ptr<cpu_set_t, void (*)(cpu_set_t*)> set(CPU_ALLOC(most),
                                                               [](cpu_set_t* s) { CPU_FREE(s); });
    if (!set) break;
    const std::size_t bytes = CPU_ALLOC_SIZE(most);
    if (sched_getaffinity(0, bytes, set.get()) == 0) {
      std::vector<int> threads;
      for (int thread = 0; thread < most; ++thread)
        if (CPU_ISSET_S(std::size_t(thread), bytes, set.get())) threads.push_back(thread);
      return threads;
    }
    if (errno != EINVAL) break;
  }
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

namespace {

#if defined(__SSE2__)
constexpr std::uint64_t flushing = 0x8040;  // flush to zero, denormals are zero
std::uint64_t float_control() { return _mm_getcsr(); }
void set_float_control(std::uint64_t bits) { _mm_setcsr(static_cast<unsigned>(bits)); }
#elif defined(__aarch64__)
constexpr std::uint64_t flushing = std::uint64_t{1} << 24;
std::uint64_t float_control() {
  std::uint64_t control = 0;
  asm volatile("mrs %0, fpcr" : "=r"(control));
  return control;
}
void set_float_control(std::uint64_t bits) { asm volatile("msr fpcr, %0" ::"r"(bits)); }
#else
constexpr std::uint64_t flushing = 0;
std::uint64_t float_control() { return 0; }
void set_float_control(std::uint64_t) {}
#endif

}  // namespace

void flush_denormals() { set_float_control(float_control() | flushing); }

KeptDenormals::KeptDenormals() : before_(float_control()) { set_float_control(before_ & ~flushing); }
KeptDenormals::~KeptDenormals() { set_float_control(before_); }

PlainFloats::PlainFloats() {
  std::feholdexcept(&before_);
  std::fesetenv(FE_DFL_ENV);
}
PlainFloats::~PlainFloats() { std::fesetenv(&before_); }

}  // namespace ringsplat
