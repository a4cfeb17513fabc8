#include "base/temporary_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <pthread.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <set>
#include <string>
#include <utility>

#include "base/output_file.hpp"
#include "base/process.hpp"

namespace ringsplat::detail {

namespace fs = std::filesystem;

namespace {

struct Place {
  std::atomic<bool> filled;
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

/// The number of the place; below 0: there is none. The lock is held.
int place_for(const fs::path& path) {
  const std::size_t length = path.native().size();
  const auto free = std::find_if(places.begin(), places.end(), [](const Place& p) { return !p.filled; });
  if (length >= PATH_MAX || free == places.end()) return -1;
  std::memcpy(free->path, path.c_str(), length + 1);
  free->filled = true;
  return int(free - places.begin());
}

/// Also true when more files are open than there are places, since then it is not known.
bool is_unfinished_here(const fs::path& path) {
  const std::lock_guard lock(places_lock);
  return overflowed > 0 || std::any_of(places.begin(), places.end(),
                                       [&](const Place& p) { return p.filled && path == p.path; });
}

/// The beginning of all hidden names of this machine. No host's is the same as another's, or begins
/// another's.
std::string host_prefix() {
  std::string prefix = ".ringsplat_";
  for (const char letter : host_name()) {
    const auto c = static_cast<unsigned char>(letter);
    const bool plain = (c < 128 && std::isalnum(c) != 0) || c == '.' || c == '-';
    prefix += plain ? std::string(1, letter) : fmt::format("%{:02X}", c);
  }
  return prefix + '_';
}

fs::path hidden_name(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  const std::string prefix = fmt::format("{}{}-{}_", host_prefix(), getpid(), counter++);
  std::string name = path.filename().string();
  const std::size_t room = prefix.size() < NAME_MAX ? NAME_MAX - prefix.size() : 0;
  if (name.size() > room) name.erase(0, name.size() - room);
  return folder_of(path) / (prefix + name);
}

/// The process number in the name of a hidden file of this host; 0: it is no such file.
pid_t maker_of(const std::string& name, const std::string& prefix) {
  pid_t pid = 0;
  unsigned counter = 0;
  int end = 0;  // behind the underscore
  const bool whole = name.starts_with(prefix) && std::isdigit(static_cast<unsigned char>(name[prefix.size()])) != 0 &&
                     std::sscanf(name.c_str() + prefix.size(), "%d-%u_%n", &pid, &counter, &end) == 2 &&
                     end > 0;
  return whole ? pid : 0;
}

/// Process numbers are reused, in containers by the very next run. So a file with this process's number may
/// be an earlier process's.
bool is_alive(pid_t pid, const fs::path& path) {
  if (pid == getpid()) return is_unfinished_here(path);
  return kill(pid, 0) == 0 || errno != ESRCH;
}

void remove_if_abandoned(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return;
  struct stat status {};
  const bool own = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == geteuid();
  // A file's writer holds its lock. That also protects it from containers that share the host's name and have
  // process numbers of their own. On a disk without locks the process number decides alone.
  if (own && (flock(descriptor, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK)) unlink(path.c_str());
  ::close(descriptor);
}

void remove_stale_files_once(const fs::path& folder) {
  static std::mutex lock;
  static std::set<fs::path> done;
  std::error_code ignored;
  const std::lock_guard held(lock);
  if (done.insert(fs::weakly_canonical(folder, ignored)).second) remove_stale_files(folder);
}

}  // namespace

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

void TemporaryFile::make() {
  const SignalsHeld held;
  descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor_ < 0) return;
  unfinished_ = true;
  const std::lock_guard lock(places_lock);
  place_ = place_for(path_);
  if (place_ < 0) ++overflowed;
}

void TemporaryFile::forget() {
  unfinished_ = false;
  const std::lock_guard lock(places_lock);
  if (place_ < 0)
    --overflowed;
  else
    places[std::size_t(place_)].filled = false;
}

TemporaryFile::TemporaryFile(const fs::path& path, std::error_code& error) {
  remove_stale_files_once(folder_of(path));
  do {
    path_ = hidden_name(path);
    make();
  } while (descriptor_ < 0 && errno == EEXIST);
  error = descriptor_ < 0 ? std::error_code(errno, std::generic_category()) : std::error_code();
  if (descriptor_ >= 0) flock(descriptor_, LOCK_SH | LOCK_NB);
}

TemporaryFile::~TemporaryFile() {
  close();
  if (!unfinished_) return;
  unlink(path_.c_str());
  forget();
}

bool TemporaryFile::close() { return descriptor_ < 0 || ::close(std::exchange(descriptor_, -1)) == 0; }

bool TemporaryFile::rename_to(const fs::path& path) {
  if (std::rename(path_.c_str(), path.c_str()) != 0) return false;
  forget();
  return true;
}

void remove_stale_files(const fs::path& folder) {
  const std::string prefix = host_prefix();
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const pid_t pid = maker_of(entry->path().filename().string(), prefix);
    if (pid != 0 && !is_alive(pid, entry->path())) remove_if_abandoned(entry->path());
  }
}

}  // namespace ringsplat::detail

void ringsplat::remove_unfinished_files() noexcept {
  const int error = errno;
  detail::ending = true;
  // From here on nobody takes a place, so none changes while it is read. The wait is bounded: opening a file
  // may hang on a network disk, and that must not keep the process from ending.
  constexpr timespec nap{0, 1'000'000};
  for (int naps = 0; detail::beginning > 0 && naps < 500; ++naps) nanosleep(&nap, nullptr);
  for (const detail::Place& place : detail::places)
    if (place.filled) unlink(place.path);
  errno = error;
}
