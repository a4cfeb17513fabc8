// Preloaded: does something to a file just before the program reads the part of it that begins at byte
// FAULT_AT, while it is open. FAULT: truncate, change or remove; or, on rank FAULT_RANK, hang (as file
// systems do) or stop; or wait: a process's n-th such read begins when there is a file FAULT_GATE + n.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

bool is_rank(const char* rank) {
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMI_RANK"})
    if (const char* mine = std::getenv(name); mine != nullptr && rank != nullptr)
      return std::strcmp(mine, rank) == 0;
  return false;
}

void harm(int descriptor, const std::string& fault) {
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  char path[4096] = {};
  if (readlink(link.c_str(), path, sizeof path - 1) < 0) return;
  if (fault == "remove") unlink(path);
  // It is open for reading only.
  const int file = open(path, O_WRONLY);
  if (file < 0) return;
  struct stat status {};
  fstat(file, &status);
  const std::string other(1000, '\xff');
  const bool done = fault == "truncate" ? ftruncate(file, status.st_size / 4) == 0
                                        : write(file, other.data(), other.size()) > 0;
  close(file);
  if (!done) std::abort();
}

std::atomic<int> reads{0};

void wait_for(const std::string& gate) {
  constexpr int between = 5000;  // microseconds
  while (access(gate.c_str(), F_OK) != 0) usleep(between);
}

}  // namespace

extern "C" ssize_t pread(int descriptor, void* bytes, size_t count, off_t offset) {
  using Pread = ssize_t (*)(int, void*, size_t, off_t);
  static const auto really = reinterpret_cast<Pread>(dlsym(RTLD_NEXT, "pread"));
  const char* const at = std::getenv("FAULT_AT");
  const char* const fault = std::getenv("FAULT");
  if (at != nullptr && fault != nullptr && std::atoll(at) == offset) {
    const bool hang = std::strcmp(fault, "hang") == 0, stop = std::strcmp(fault, "stop") == 0;
    if (const char* const gate = std::getenv("FAULT_GATE"); gate != nullptr)
      wait_for(gate + std::to_string(++reads));
    else if (!hang && !stop)
      harm(descriptor, fault);
    while (hang && is_rank(std::getenv("FAULT_RANK"))) pause();
    if (stop && is_rank(std::getenv("FAULT_RANK"))) raise(SIGSTOP);
  }
  return really(descriptor, bytes, count, offset);
}
