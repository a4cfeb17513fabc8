#include "base/output_file.hpp"

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
#include <system_error>
#include <utility>

#include "base/log.hpp"
#include "base/process.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

namespace fs = std::filesystem;

namespace {

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

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
  const bool whole =
      name.starts_with(prefix) && std::isdigit(static_cast<unsigned char>(name[prefix.size()])) != 0 &&
      std::sscanf(name.c_str() + prefix.size(), "%d-%u_%n", &pid, &counter, &end) == 2 && end > 0;
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

/// A hidden file beside `path`, `.ringsplat_HOST_PID-N_NAME`: HOST with every byte but letters, digits, dots
/// and dashes as %XX, N counted by the process, NAME that of `path`, cut from the front when it is too long.
/// Locked while it is open. remove_unfinished_files() removes it while this object lives; there are places
/// for 64 at a time, and further ones are not registered.
class TemporaryFile {
 public:
  /// Says in `error` why it could not be made; nothing else may be called then. The first one in a folder
  /// removes what dead processes left there. No signal arrives between making the file and registering it.
  TemporaryFile(const fs::path& path, std::error_code& error) {
    remove_stale_files_once(folder_of(path));
    do {
      path_ = hidden_name(path);
      make();
    } while (descriptor_ < 0 && errno == EEXIST);
    error = descriptor_ < 0 ? std::error_code(errno, std::generic_category()) : std::error_code();
    if (descriptor_ >= 0) flock(descriptor_, LOCK_SH | LOCK_NB);
  }

  ~TemporaryFile() {
    close();
    if (!unfinished_) return;
    unlink(path_.c_str());
    forget();
  }

  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const std::filesystem::path& path() const { return path_; }
  int descriptor() const { return descriptor_; }  ///< below 0: closed
  /// errno says why not; it is closed in any case.
  bool close() { return descriptor_ < 0 || ::close(std::exchange(descriptor_, -1)) == 0; }
  /// Keeps the file, under that name. errno says why not.
  bool rename_to(const fs::path& path) {
    if (std::rename(path_.c_str(), path.c_str()) != 0) return false;
    forget();
    return true;
  }

 private:
  void make() {
    const SignalsHeld held;
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) return;
    unfinished_ = true;
    const std::lock_guard lock(places_lock);
    place_ = place_for(path_);
    if (place_ < 0) ++overflowed;
  }

  void forget() {
    unfinished_ = false;
    const std::lock_guard lock(places_lock);
    if (place_ < 0)
      --overflowed;
    else
      places[std::size_t(place_)].filled = false;
  }

  std::filesystem::path path_;
  int descriptor_ = -1;
  bool unfinished_ = false;
  int place_ = -1;  ///< below 0: not registered
};

namespace {

constexpr std::size_t buffer_bytes = std::size_t{1} << 20;

bool is_the_disks_fault(int reason) {
  return reason == ENOSPC || reason == EDQUOT || reason == EFBIG || reason == EIO;
}

const char* hint_for(int reason) {
  if (reason == ENOSPC || reason == EDQUOT) return "make room on the disk, or choose another one";
  if (reason == EFBIG)
    return "the file is larger than this disk or the limit of files' sizes (ulimit -f) allows";
  return "choose a folder that you may write to, on a disk that works";
}

std::string reason_text(int reason) { return std::generic_category().message(reason); }

/// Why the name cannot be a file's, as an errno value; 0: it can.
int unusable(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!path.has_filename() || fs::is_directory(status)) return EISDIR;
  // A device would be replaced by a file.
  return fs::exists(status) && !fs::is_regular_file(status) ? ENOTSUP : 0;
}

/// Where a link of this user's leads: to a file of this user's, or a new one. A link that is another's, or
/// leads to another's file, may lead to what nobody wanted to replace: it is itself what the file replaces.
fs::path behind_links(const fs::path& path) {
  constexpr int most_links = 40;
  fs::path at = path;
  for (int links = 0; links < most_links; ++links) {
    struct stat status {};
    if (::lstat(at.c_str(), &status) != 0) return at;
    if (status.st_uid != geteuid()) break;
    if (!S_ISLNK(status.st_mode)) return at;
    std::error_code error;
    at = folder_of(at) / fs::read_symlink(at, error);
    if (error) break;
  }
  std::error_code ignored;
  if (fs::is_symlink(path, ignored))
    log_warning_once("{} is a link to what is not this user's: a file takes the link's place", path.string());
  return path;
}

}  // namespace

OutputFile::OutputFile(fs::path path) : path_(std::move(path)) {
  if (const int reason = unusable(path_)) fail(reason);
  path_ = behind_links(path_);
  std::error_code error;
  file_ = std::make_unique<TemporaryFile>(path_, error);
  if (error) fail(error.value());
}

OutputFile::~OutputFile() = default;

void OutputFile::write(std::span<const std::byte> bytes) {
  if (buffer_.size() + bytes.size() > buffer_bytes) flush_buffer();
  if (bytes.size() >= buffer_bytes)
    put(bytes);
  else
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  size_ += bytes.size();
}

void OutputFile::flush_buffer() {
  put(buffer_);
  buffer_.clear();
}

void OutputFile::put(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_->descriptor(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(written < 0 ? errno : EIO);
    bytes = bytes.subspan(std::size_t(written));
  }
}

void OutputFile::secure() {
  if (secured_) return;
  flush_buffer();
  // Some disks report a lack of room, or a failure, only here. Others cannot flush at all.
  while (::fsync(file_->descriptor()) != 0)
    if (errno == EINVAL || errno == ENOTSUP)
      break;
    else if (errno != EINTR)
      fail(errno);
  if (!file_->close()) fail(errno);
  struct stat status {};
  if (::stat(file_->path().c_str(), &status) != 0) fail(errno);
  if (std::uint64_t(status.st_size) != size_) fail(EIO);
  secured_ = true;
}

void OutputFile::commit() {
  secure();
  if (!file_->rename_to(path_)) fail(errno);
}

void OutputFile::fail(int reason) const {
  throw RunError(fmt::format("{} cannot be written: {}", path_.string(), reason_text(reason)),
                 hint_for(reason));
}

void write_text(const fs::path& path, const std::string& text) { write_texts({{path, text}}); }

void write_texts(const std::vector<std::pair<fs::path, std::string>>& files) {
  std::vector<std::unique_ptr<OutputFile>> written;
  for (const auto& [path, text] : files) {
    written.push_back(std::make_unique<OutputFile>(path));
    written.back()->write(text);
  }
  for (const auto& file : written) file->secure();
  for (const auto& file : written) file->commit();
}

void check_can_write(const fs::path& path, const std::string& option) {
  const fs::path file = behind_links(path), folder = folder_of(file);
  std::error_code error;
  const int reason = unusable(path);
  if (reason == EISDIR)
    throw InputError(fmt::format("{} {} is a folder", option, path.string()), "name a file in it");
  if (reason != 0)
    throw InputError(fmt::format("{} {} is no regular file", option, path.string()), "name one");
  if (!fs::is_directory(folder, error))
    throw InputError(fmt::format("{}: there is no folder {}", option, folder.string()),
                     fmt::format("make it first: mkdir -p {}", folder.string()));
  const TemporaryFile probe(file, error);
  if (!error) return;
  const std::string problem =
      fmt::format("{} {} cannot be written: {}", option, path.string(), error.message());
  if (is_the_disks_fault(error.value())) throw RunError(problem, hint_for(error.value()));
  throw InputError(problem, hint_for(error.value()));
}

void remove_stale_files(const fs::path& folder) {
  const std::string prefix = host_prefix();
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const pid_t pid = maker_of(entry->path().filename().string(), prefix);
    if (pid != 0 && !is_alive(pid, entry->path())) remove_if_abandoned(entry->path());
  }
}

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
