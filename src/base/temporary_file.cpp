#include "base/temporary_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <climits>
#include <cstdio>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "base/process.hpp"

namespace ringsplat::detail {

namespace fs = std::filesystem;

namespace {

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
  if (name.compare(0, prefix.size(), prefix) != 0) return 0;
  const char* const end = name.data() + name.size();
  pid_t pid = 0;
  unsigned counter = 0;
  const auto after_pid = std::from_chars(name.data() + prefix.size(), end, pid);
  if (after_pid.ec != std::errc{} || pid <= 0 || after_pid.ptr == end || *after_pid.ptr != '-') return 0;
  const auto after_counter = std::from_chars(after_pid.ptr + 1, end, counter);
  const bool whole = after_counter.ec == std::errc{} && after_counter.ptr != end && *after_counter.ptr == '_';
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

TemporaryFile::TemporaryFile(const fs::path& path, std::error_code& error) {
  remove_stale_files_once(folder_of(path));
  do {
    path_ = hidden_name(path);
    unfinished_ = std::make_unique<UnfinishedFile>(path_);
  } while (unfinished_->descriptor() < 0 && errno == EEXIST);
  descriptor_ = unfinished_->descriptor();
  error = descriptor_ < 0 ? std::error_code(errno, std::generic_category()) : std::error_code();
  if (descriptor_ >= 0) flock(descriptor_, LOCK_SH | LOCK_NB);
}

TemporaryFile::~TemporaryFile() {
  close();
  if (unfinished_ && unfinished_->descriptor() >= 0) unlink(path_.c_str());
}

bool TemporaryFile::close() { return descriptor_ < 0 || ::close(std::exchange(descriptor_, -1)) == 0; }

bool TemporaryFile::rename_to(const fs::path& path) {
  if (std::rename(path_.c_str(), path.c_str()) != 0) return false;
  unfinished_.reset();
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
