#include "base/output_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <mutex>
#include <set>
#include <system_error>

#include "base/log.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

namespace fs = std::filesystem;

namespace {

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

constexpr std::string_view mark = ".ringsplat_";

/// A hidden file's name beside `path` that this process has not used.
fs::path hidden_name(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  return folder_of(path) / fmt::format("{}{}-{}", mark, getpid(), counter++);
}

/// A file's writer holds a lock on it, but may not have come to that yet.
void remove_if_abandoned(const fs::path& path) {
  constexpr time_t old_enough = 60;  // seconds
  const int descriptor = ::open(path.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return;
  struct stat status {};
  const bool own = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == geteuid();
  if (own && time(nullptr) - status.st_mtime > old_enough && flock(descriptor, LOCK_EX | LOCK_NB) == 0)
    unlink(path.c_str());
  ::close(descriptor);
}

/// Removes the hidden files that killed processes of this user left in a folder. In doubt a file stays.
void remove_abandoned_once(const fs::path& folder) {
  static std::mutex lock;
  static std::set<fs::path> done;
  std::error_code error;
  const std::lock_guard held(lock);
  if (!done.insert(fs::weakly_canonical(folder, error)).second) return;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with(mark) && name.size() > mark.size() &&
        std::isdigit(static_cast<unsigned char>(name[mark.size()])) != 0)
      remove_if_abandoned(entry->path());
  }
}

const char* hint_for(int reason) {
  if (reason == ENOSPC || reason == EDQUOT) return "make room on the disk, or choose another one";
  if (reason == EFBIG)
    return "the file is larger than this disk or the limit of files' sizes (ulimit -f) allows";
  return "choose a folder that you may write to, on a disk that works";
}

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

/// What is written before it has its name. Where the disk can, it is a file without any, of which nothing
/// stays however the process ends. Elsewhere it is a hidden file beside `path`, locked while it is open,
/// which goes with this object; of a killed process it stays until another writes into the folder.
class TemporaryFile {
 public:
  /// Says in `error` why it could not be made; nothing else may be called then.
  TemporaryFile(const fs::path& path, std::error_code& error) {
    remove_abandoned_once(folder_of(path));
    descriptor_ = ::open(folder_of(path).c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
    const auto made = [this](const fs::path& name) {
      descriptor_ = ::open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      return descriptor_ >= 0;
    };
    if (descriptor_ < 0 && hide_beside(path, made)) flock(descriptor_, LOCK_SH | LOCK_NB);
    error = descriptor_ < 0 ? std::error_code(errno, std::generic_category()) : std::error_code();
  }

  ~TemporaryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!hidden_.empty()) unlink(hidden_.c_str());
  }

  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  int descriptor() const { return descriptor_; }  ///< below 0: closed
  /// Some disks report only now that they could not write; those have no files without names. errno says why
  /// not.
  bool close() { return hidden_.empty() || descriptor_ < 0 || ::close(std::exchange(descriptor_, -1)) == 0; }
  /// Keeps the file, under that name. errno says why not.
  bool rename_to(const fs::path& path) {
    const auto named = [this](const fs::path& name) {
      const std::string nameless = fmt::format("/proc/self/fd/{}", descriptor_);
      return ::linkat(AT_FDCWD, nameless.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
    };
    // No file can be given the name of another one, so it gets a hidden one first.
    if (hidden_.empty() && named(path)) return true;
    if (hidden_.empty() && !hide_beside(path, named)) return false;
    if (std::rename(hidden_.c_str(), path.c_str()) != 0) return false;
    hidden_.clear();
    return true;
  }

 private:
  /// False where `make` makes nothing of any hidden name; errno says why.
  bool hide_beside(const fs::path& path, auto&& make) {
    do {
      hidden_ = hidden_name(path);
      if (make(hidden_)) return true;
    } while (errno == EEXIST);
    hidden_.clear();
    return false;
  }

  fs::path hidden_;  ///< empty: the file has no name
  int descriptor_ = -1;
};

OutputFile::OutputFile(fs::path path) : path_(std::move(path)) {
  if (const int reason = unusable(path_)) fail(reason);
  path_ = behind_links(path_);
  std::error_code error;
  file_ = std::make_unique<TemporaryFile>(path_, error);
  if (error) fail(error.value());
}

OutputFile::~OutputFile() = default;

void OutputFile::write(std::span<const std::byte> bytes) {
  size_ += bytes.size();
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_->descriptor(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(written < 0 ? errno : EIO);
    bytes = bytes.subspan(std::size_t(written));
  }
}

void OutputFile::secure() {
  if (secured_) return;
  // Some disks report a lack of room, or a failure, only here. Others cannot flush at all.
  while (::fsync(file_->descriptor()) != 0)
    if (errno == EINVAL || errno == ENOTSUP)
      break;
    else if (errno != EINTR)
      fail(errno);
  struct stat status {};
  if (::fstat(file_->descriptor(), &status) != 0 || !file_->close()) fail(errno);
  if (std::uint64_t(status.st_size) != size_) fail(EIO);
  secured_ = true;
}

void OutputFile::commit() {
  secure();
  if (!file_->rename_to(path_)) fail(errno);
}

void OutputFile::fail(int reason) const {
  throw RunError(
      fmt::format("{} cannot be written: {}", path_.string(), std::generic_category().message(reason)),
      hint_for(reason));
}

void write_text(const fs::path& path, const std::string& text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
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
  const int why = error.value();
  const bool disks_fault = why == ENOSPC || why == EDQUOT || why == EFBIG || why == EIO;
  if (disks_fault) throw RunError(problem, hint_for(why));
  throw InputError(problem, hint_for(why));
}

}  // namespace ringsplat
