#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include "base/log.hpp"
#include "base/text.hpp"
#include "decode/readers.hpp"
#include "formats/decode/messages.hpp"

namespace ringsplat::decode {
namespace {

using namespace detail;
using Kind = DecodeRequest::Kind;

/// The memory that is shared with the other process, which has made it as large as is needed.
class SharedMemory {
 public:
  std::span<std::byte> first(std::size_t bytes) {
    if (bytes > mapped_.size()) {
      if (!mapped_.empty()) ::munmap(mapped_.data(), mapped_.size());
      mapped_ = {};
      void* const at = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, decode_memory, 0);
      if (at == MAP_FAILED) throw std::bad_alloc();
      mapped_ = {static_cast<std::byte*>(at), bytes};
    }
    return mapped_.first(bytes);
  }

 private:
  std::span<std::byte> mapped_;
};

/// From when it is made, what libraries print goes nowhere but here.
class ForeignLines {
 public:
  ForeignLines() : caught_(::memfd_create("stderr", MFD_CLOEXEC)) {
    if (caught_ >= 0) ::dup2(caught_, STDERR_FILENO);
  }
  /// The first line since it was last asked for; empty for none.
  std::string first_line() {
    constexpr off_t most = 1000;
    std::fflush(stderr);
    std::string text(std::size_t(std::clamp<off_t>(::lseek(caught_, 0, SEEK_END), 0, most)), '\0');
    text.resize(std::size_t(std::max<ssize_t>(0, ::pread(caught_, text.data(), text.size(), 0))));
    if (!text.empty() && ::ftruncate(caught_, 0) == 0) ::lseek(caught_, 0, SEEK_SET);
    return text.substr(0, text.find('\n'));
  }

 private:
  int caught_;  ///< descriptor of what they print
};

/// Answers the requests of the process that started this program, until that has ended.
class Server {
 public:
  Server() {
    set_log_sink([this](LogLevel level, const std::string& text) { answer_.log.push_back({level, text}); });
  }
  ~Server() { set_log_sink({}); }

  void run() {
    while (const auto message = receive_message(decode_socket)) {
      const auto request = from_bytes<DecodeRequest>(*message);
      if (!request) return;
      if (request->kind == Kind::close) {
        sources_.erase(request->source);
        continue;
      }
      answer_ = {};
      try_to(*request);
      if (!send_message(decode_socket, to_bytes(answer_))) return;
    }
  }

 private:
  /// Whatever is thrown is the file's fault.
  void try_to(const DecodeRequest& request) {
    const std::string& path = request.path;
    const auto fail = [&](const Error& error) { answer_.failure = {error.exit_code(), error.what()}; };
    try {
      answer(request);
    } catch (const Error& error) {
      fail(error);
    } catch (const std::filesystem::filesystem_error& error) {
      fail(InputError(fmt::format("cannot open {}: {}", path, error.code().message()),
                      "check the path and the permissions"));
    } catch (const std::bad_alloc&) {
      fail(InputError(fmt::format("{} needs more memory than there is", path), "check its sizes"));
    } catch (const std::exception& error) {
      fail(InputError(fmt::format("cannot read {}: {}", path, one_line(error.what())),
                      "check the file with another viewer"));
    }
    const auto line = foreign_.first_line();
    if (!line.empty() && !answer_.failure) log_warning_once("{}: {}", path, line);
  }

  void answer(const DecodeRequest& request) {
    if (request.kind == Kind::open) return open(request);
    VolumeSource& volume = *sources_.at(request.source);
    if (request.kind == Kind::facts) {
      progress();
      answer_.facts = volume.facts();
      return;
    }
    const std::size_t bytes = volume.grid().slice_bytes(Axis::z) * std::size_t(request.count);
    progress(volume.concurrent() ? bytes : volume.grid().bytes());
    volume.read_slices(request.first, request.count, memory_.first(bytes));
  }

  void open(const DecodeRequest& request) {
    std::filesystem::current_path(request.folder);
    std::error_code none;  // for a folder, and where there are more words behind a file's name
    const auto bytes = std::filesystem::file_size(request.path, none);
    progress(none ? 0 : bytes);
    DecodedVolume& told = answer_.volume;
    auto source = request.format == DecodedFormat::hdf5
                      ? read_hdf5(request.path, request.choice, told.in_place)
                  : request.format == DecodedFormat::tiff ? read_tiff(request.path, request.choice)
                                                          : read_dicom(request.path, request.choice);
    told.grid = source->grid();
    told.concurrent = source->concurrent();
    told.layer_depth = source->layer_depth();
    told.notes = source->notes();
    sources_[request.source] = std::move(source);
  }

  DecodeAnswer answer_;
  std::map<std::uint32_t, std::unique_ptr<VolumeSource>> sources_;
  SharedMemory memory_;
  ForeignLines foreign_;
};

}  // namespace
}  // namespace ringsplat::decode

/// Reads volumes for a process that starts it with a socket and memory that both share.
int main(int argc, char** argv) {
  int type = 0;
  socklen_t size = sizeof type;
  if (argc != 2 || getsockopt(ringsplat::detail::decode_socket, SOL_SOCKET, SO_TYPE, &type, &size) != 0) {
    std::fputs("ringsplat-decode reads DICOM, TIFF and HDF5 for ringsplat, which starts it\n", stderr);
    return 2;
  }
  if (std::string_view(argv[1]) != RINGSPLAT_VERSION) return ringsplat::detail::other_version_code;
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  ringsplat::decode::Server().run();
  _exit(0);  // libraries cannot always close damaged files
}
