#include "base/unfinished_files.hpp"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstring>
#include <mutex>

#include "base/output_file.hpp"

namespace ringsplat {
namespace {

struct Place {
  std::atomic<bool> taken, filled;
  char path[PATH_MAX];
};
// A signal handler may neither allocate memory nor lock. The lock is between threads only.
std::array<Place, 64> places;
std::mutex places_lock;
std::atomic<int> overflowed{0};
std::atomic<int> beginning{0};  ///< threads between asking for a place and having their file
std::atomic<bool> ending{false};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

/// Blocks signals on this thread while it lives: a handler here that waits for `beginning` would wait for
/// itself.
class SignalsHeld {
 public:
  SignalsHeld() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before_);
    ++beginning;
    while (ending) {
      --beginning;
      for (;;) pause();
    }
  }
  ~SignalsHeld() {
    --beginning;
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;

 private:
  sigset_t before_{};
};

int place_for(const char* path, std::size_t length) {
  if (length >= PATH_MAX) return -1;
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (places[k].taken.exchange(true)) continue;
    std::memcpy(places[k].path, path, length + 1);
    places[k].filled = true;
    return int(k);
  }
  return -1;
}

}  // namespace

namespace detail {

UnfinishedFile::UnfinishedFile(const std::filesystem::path& path) {
  const SignalsHeld held;
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor_ < 0) return;
  const std::lock_guard lock(places_lock);
  place_ = place_for(path.c_str(), path.native().size());
  if (place_ < 0) ++overflowed;
}

UnfinishedFile::~UnfinishedFile() {
  if (descriptor_ < 0) return;
  if (place_ < 0) {
    --overflowed;
    return;
  }
  Place& place = places[std::size_t(place_)];
  place.filled = false;
  place.taken = false;
}

bool is_unfinished_here(const std::filesystem::path& path) {
  if (overflowed > 0) return true;
  const std::lock_guard lock(places_lock);
  for (const Place& place : places)
    if (place.filled && path == place.path) return true;
  return false;
}

}  // namespace detail

void remove_unfinished_files() noexcept {
  const int error = errno;
  ending = true;
  // From here on nobody takes a place, so none changes while it is read. The wait is bounded: opening a file
  // may hang on a network disk, and that must not keep the process from ending.
  constexpr timespec nap{0, 1'000'000};
  for (int naps = 0; beginning > 0 && naps < 500; ++naps) nanosleep(&nap, nullptr);
  for (const Place& place : places)
    if (place.filled) unlink(place.path);
  errno = error;
}

}  // namespace ringsplat
