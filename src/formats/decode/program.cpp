#include "formats/decode/program.hpp"

#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <new>

#include "base/child_program.hpp"
#include "base/process.hpp"
#include "formats/limits.hpp"

namespace ringsplat::detail {
namespace {

constexpr const char* program_name = "ringsplat-decode";

/// Beside what this code is part of, where that looks for its libraries, in the folder of programs beside
/// these, or in PATH.
std::filesystem::path find_decode_program() {
  const auto own = own_folder();
  if (is_program(own / program_name)) return own / program_name;
  for (const auto& folder : own_search_path())
    for (const auto& place : {folder, folder / ".." / "bin"})
      if (is_program(place / program_name)) return place / program_name;
  if (const auto found = find_program(program_name)) return *found;
  throw InputError(
      fmt::format("{}, which reads DICOM, TIFF and HDF5, is missing", program_name),
      fmt::format("it belongs beside ringsplat, here in {}: install again, or name its folder in PATH",
                  own.string()));
}

}  // namespace

std::shared_ptr<DecodeProgram> DecodeProgram::running() {
  static std::mutex mutex;
  static std::shared_ptr<DecodeProgram> last;
  const std::lock_guard lock(mutex);
  if (!last || last->ended()) last = std::make_shared<DecodeProgram>(find_decode_program());
  return last;
}

DecodeProgram::DecodeProgram(const std::string& file) : owner_(::getpid()) {
  std::array<int, 2> ends{-1, -1};
  memory_ = ::memfd_create("voxels", MFD_CLOEXEC);
  if (memory_ < 0 || ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw RunError(fmt::format("{} cannot be started: {}", program_name, std::strerror(errno)),
                   "free memory, or raise the limit of open files");
  socket_ = ends[0];
  child_ = start_program(file, {RINGSPLAT_VERSION}, ".", {ends[1], memory_});
  ::close(ends[1]);
}

DecodeProgram::~DecodeProgram() {
  ::close(socket_);
  ::close(memory_);
  if (::getpid() == owner_ && !ended_) end();
}

int DecodeProgram::end() {
  int status = 0;
  ::kill(child_, SIGKILL);
  while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) {
  }
  ended_ = true;
  return status;
}

bool DecodeProgram::ended() const {
  const std::lock_guard lock(mutex_);
  return ended_ || ::getpid() != owner_;  // a copy of the process that it belongs to
}

void DecodeProgram::close(std::uint32_t source) {
  const std::lock_guard lock(mutex_);
  if (ended_ || ::getpid() != owner_) return;
  send_message(socket_, to_bytes(DecodeRequest{.kind = DecodeRequest::Kind::close, .source = source}));
  static_cast<void>(::ftruncate(memory_, 0));  // the next request makes it as large as it needs
}

DecodeAnswer DecodeProgram::ask(const DecodeRequest& request, std::span<std::byte> voxels) {
  const std::lock_guard lock(mutex_);
  struct stat status {};
  if (!voxels.empty() &&
      (::fstat(memory_, &status) != 0 ||
       (std::size_t(status.st_size) < voxels.size() && ::ftruncate(memory_, off_t(voxels.size())) != 0)))
    throw std::bad_alloc();
  std::optional<Bytes> message;
  if (!ended_ && send_message(socket_, to_bytes(request))) message = receive_message(socket_);
  auto answer = message ? from_bytes<DecodeAnswer>(*message) : std::nullopt;
  if (!answer) throw_why_it_ended(request);
  for (const auto& line : answer->log) log_line_once(line.level, line.text);
  if (answer->failure && answer->failure->code == ExitCode::bad_input)
    throw InputError(answer->failure->what);
  if (answer->failure) throw RunError(answer->failure->what);
  for (std::size_t at = 0; at < voxels.size();) {
    const auto got = ::pread(memory_, voxels.data() + at, voxels.size() - at, off_t(at));
    if (got > 0) at += std::size_t(got);
    if (got == 0 || (got < 0 && errno != EINTR)) throw_why_it_ended(request);
  }
  return std::move(*answer);
}

void DecodeProgram::throw_why_it_ended(const DecodeRequest& request) {
  constexpr const char* libraries[] = {"HDF5", "OpenImageIO", "GDCM"};  // by DecodedFormat
  const int status = ended_ ? 0 : end();  // it may live on and say what cannot be understood
  const int by = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  if (WIFEXITED(status) && WEXITSTATUS(status) == other_version_code)
    throw InputError(fmt::format("{} is of another version than this program", program_name),
                     "install them together");
  const std::string how = by == SIGXCPU ? "comes to no end with it"
                          : by == 0     ? fmt::format("ends on it (exit code {})", WEXITSTATUS(status))
                                        : fmt::format("crashes on it ({})", strsignal(by));
  refuse(request.path, "the file is damaged: copy it again", "{} {}", libraries[std::size_t(request.format)],
         how);
}

}  // namespace ringsplat::detail
