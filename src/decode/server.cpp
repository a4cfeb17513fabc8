#include "decode/server.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <map>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "base/log.hpp"
#include "base/text.hpp"
#include "decode/foreign_lines.hpp"
#include "decode/progress.hpp"
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

/// 0 for a folder, and where there are more words behind a file's name.
std::uint64_t bytes_of_file(const std::filesystem::path& path) {
  std::error_code none;
  const auto bytes = std::filesystem::file_size(path, none);
  return none ? 0 : bytes;
}

class Server {
 public:
  Server() {
    set_log_sink([this](LogLevel level, const std::string& text) { answer_.log.push_back({level, text}); });
  }
  ~Server() { set_log_sink({}); }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

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
    progress(bytes_of_file(request.path));
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

void serve() { Server().run(); }

}  // namespace ringsplat::decode
