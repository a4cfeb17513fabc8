#include "formats/hdf5/trial.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>

#include "formats/hdf5/library.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat::detail::hdf5 {
namespace {

constexpr rlim_t most_seconds = 10;
constexpr unsigned most_wait = 60;  ///< seconds until the trial is given up without a result

/// Leaves by _exit(), so that nothing of the parent's is ended or written twice.
[[noreturn]] void run_in_child(const std::function<void()>& use) {
  for (const int fatal :
       {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGXCPU, SIGALRM, SIGTERM, SIGINT, SIGHUP})
    std::signal(fatal, SIG_DFL);
  ::alarm(most_wait);  // should it wait for what no thread of a copied process gives
  const rlimit seconds{most_seconds, most_seconds + 1}, no_core{0, 0};
  setrlimit(RLIMIT_CPU, &seconds);
  setrlimit(RLIMIT_CORE, &no_core);
  // The C library's last words on damaged memory, and warnings, which the parent gives again.
  const int nowhere = ::open("/dev/null", O_WRONLY);
  if (nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
  try {
    use();
  } catch (const std::exception&) {
  }
  _exit(0);
}

}  // namespace

void try_first(const std::filesystem::path& file, const std::function<void()>& use) {
  const Quiet quiet;  // no other thread is within HDF5 when the process is copied
  const pid_t child = ::fork();
  if (child < 0) return;
  if (child == 0) run_in_child(use);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return;
  // A sanitizer's report ends a process without a signal.
  if (WIFEXITED(status) && WEXITSTATUS(status) != 0)
    throw InputError(fmt::format("{}: HDF5 ends on it (exit code {})", file.string(), WEXITSTATUS(status)),
                     "the file is damaged: copy it again");
  if (!WIFSIGNALED(status) || WTERMSIG(status) == SIGALRM) return;
  const int ended_by = WTERMSIG(status);
  throw InputError(ended_by == SIGXCPU || ended_by == SIGKILL
                       ? fmt::format("{}: HDF5 comes to no end with it", file.string())
                       : fmt::format("{}: HDF5 crashes on it ({})", file.string(), strsignal(ended_by)),
                   "the file is damaged: copy it again");
}

void leave_open_at_exit() { H5dont_atexit(); }

}  // namespace ringsplat::detail::hdf5
