#include "base/output_file.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "base/log.hpp"
#include "base/temporary_file.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

namespace fs = std::filesystem;

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
    at = detail::folder_of(at) / fs::read_symlink(at, error);
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
  file_ = std::make_unique<detail::TemporaryFile>(path_, error);
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
  const fs::path file = behind_links(path), folder = detail::folder_of(file);
  std::error_code error;
  const int reason = unusable(path);
  if (reason == EISDIR)
    throw InputError(fmt::format("{} {} is a folder", option, path.string()), "name a file in it");
  if (reason != 0)
    throw InputError(fmt::format("{} {} is no regular file", option, path.string()), "name one");
  if (!fs::is_directory(folder, error))
    throw InputError(fmt::format("{}: there is no folder {}", option, folder.string()),
                     fmt::format("make it first: mkdir -p {}", folder.string()));
  const detail::TemporaryFile probe(file, error);
  if (!error) return;
  const std::string problem =
      fmt::format("{} {} cannot be written: {}", option, path.string(), error.message());
  if (is_the_disks_fault(error.value())) throw RunError(problem, hint_for(error.value()));
  throw InputError(problem, hint_for(error.value()));
}

}  // namespace ringsplat
