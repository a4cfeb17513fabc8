#include "formats/decode/program.hpp"

#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <new>
#include <utility>

#include "base/child_program.hpp"
#include "base/process.hpp"
#include "formats/formats.hpp"
#include "formats/limits.hpp"
#include "volume/forwarding_source.hpp"

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

namespace {

/// Of each answer, so that it is copied while it lies in the processor's caches.
constexpr std::uint64_t usual_bytes = std::uint64_t{4} << 20;

/// A volume as the program has it open. Other files may end the program; then it is opened again in the next.
class DecodedSource final : public VolumeSource {
 public:
  DecodedSource(DecodedFormat format, const std::filesystem::path& path, const VolumeChoice& choice)
      : request_{.format = format,
                 .folder = std::filesystem::current_path().string(),
                 .path = path.string(),
                 .choice = choice},
        volume_(open_anew()) {}
  ~DecodedSource() override { program_->close(request_.source); }
  DecodedSource(const DecodedSource&) = delete;
  DecodedSource& operator=(const DecodedSource&) = delete;

  const std::optional<StoredVoxels>& in_place() const { return volume_.in_place; }
  const Grid& grid() const override { return volume_.grid; }
  bool concurrent() const override { return volume_.concurrent; }
  int layer_depth() const override { return volume_.layer_depth; }
  VolumeNotes notes() const override { return volume_.notes; }
  Facts facts() const override { return ask(DecodeRequest::Kind::facts).facts; }

  void read_slices(int first, int count, std::span<std::byte> out) override {
    const auto bytes = grid().slice_bytes(Axis::z);
    const int depth = layer_depth();
    const int layers = int(std::max<std::uint64_t>(1, usual_bytes / (bytes * std::uint64_t(depth))));
    for (int z = first, end = first + count; z < end;) {
      const int stop = int(std::min<std::int64_t>(end, (z / depth + std::int64_t{layers}) * depth));
      ask(DecodeRequest::Kind::read, z, stop - z,
          out.subspan(std::size_t(z - first) * bytes, std::size_t(stop - z) * bytes));
      z = stop;
    }
  }

 private:
  DecodedVolume open_anew() const {
    program_ = DecodeProgram::running();
    static std::atomic<std::uint32_t> sources = 0;  // that were ever opened
    request_.source = ++sources;
    return program_->ask(request_).volume;
  }

  DecodeAnswer ask(DecodeRequest::Kind kind, int first = 0, int count = 0,
                   std::span<std::byte> out = {}) const {
    if (program_->ended()) open_anew();
    DecodeRequest request = request_;
    request.kind = kind;
    request.first = first;
    request.count = count;
    return program_->ask(request, out);
  }

  mutable DecodeRequest request_;  ///< that opens it
  mutable std::shared_ptr<DecodeProgram> program_;
  DecodedVolume volume_;
};

std::unique_ptr<VolumeSource> open_decoded(DecodedFormat format, const std::filesystem::path& path,
                                           const VolumeChoice& choice) {
  auto source = std::make_unique<DecodedSource>(format, path, choice);
  if (!source->in_place()) return source;
  return with_notes(stored_source(source->grid(), {*source->in_place()}), source->notes());
}

}  // namespace

std::unique_ptr<VolumeSource> open_hdf5(const std::filesystem::path& path, const VolumeChoice& choice) {
  return open_decoded(DecodedFormat::hdf5, path, choice);
}
std::unique_ptr<VolumeSource> open_tiff(const std::filesystem::path& path, const VolumeChoice& choice) {
  return open_decoded(DecodedFormat::tiff, path, choice);
}
std::unique_ptr<VolumeSource> open_dicom(const std::filesystem::path& path, const VolumeChoice& choice) {
  return open_decoded(DecodedFormat::dicom, path, choice);
}

}  // namespace ringsplat::detail
