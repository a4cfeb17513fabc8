#include "decode/readers.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <thread>

namespace ringsplat::detail {
namespace {

void set_limit(__rlimit_resource resource, rlim_t amount) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0) return;
  limit.rlim_cur = std::min(amount, limit.rlim_max);
  setrlimit(resource, &limit);
}

void limit_time(std::uint64_t bytes) {
  constexpr rlim_t least_seconds = 10;
  constexpr std::uint64_t bytes_a_second = std::uint64_t{4} << 20;  // of the slowest coders and machines
  rusage used{};
  if (getrusage(RUSAGE_SELF, &used) != 0) return;
  const auto seconds = rlim_t(used.ru_utime.tv_sec + used.ru_stime.tv_sec) + 1;
  set_limit(RLIMIT_CPU, seconds + least_seconds + rlim_t(bytes / bytes_a_second));
}

/// Of what is written to: files that are mapped may be larger. What libraries reserve for each thread counts,
/// too. Sanitizers reserve any amount.
void limit_memory([[maybe_unused]] std::uint64_t bytes) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  constexpr std::uint64_t least = std::uint64_t{2} << 30, of_a_thread = std::uint64_t{160} << 20;
  constexpr std::uint64_t copies = 4;  // encoded, decoded, rescaled, handed over
  std::uint64_t pages = 0;
  if (!(std::ifstream("/proc/self/statm") >> pages)) return;
  const auto used = pages * std::uint64_t(::sysconf(_SC_PAGESIZE));
  const auto more = least + std::thread::hardware_concurrency() * of_a_thread;
  const auto wanted = std::min(bytes, ~std::uint64_t{0} / (2 * copies)) * copies;
  set_limit(RLIMIT_DATA, used + more + wanted);
#endif
}

}  // namespace

void progress(std::uint64_t bytes) {
  limit_time(bytes);
  limit_memory(bytes);
}

}  // namespace ringsplat::detail
