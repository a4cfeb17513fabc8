#pragma once
#include <sys/types.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "formats/decode/messages.hpp"

namespace ringsplat::detail {

/// The program ringsplat-decode, started by this process: in it, libraries that read volumes may crash, run
/// for ever, or take more memory than there is. It ends with this process.
class DecodeProgram {
 public:
  /// The one of this process. It is started when there is none, or when the last one has ended. Throws
  /// InputError when it is not found, RunError when it does not start.
  static std::shared_ptr<DecodeProgram> running();

  explicit DecodeProgram(const std::string& file);
  ~DecodeProgram();

  /// Passes the answer's lines on to the log. Throws its failure, and InputError that names the file and the
  /// library that reads it when the program ends instead of answering. Of a request to read, `voxels` are
  /// filled.
  DecodeAnswer ask(const DecodeRequest& request, std::span<std::byte> voxels = {});
  /// Says that a source is no longer needed.
  void close(std::uint32_t source);

  bool ended() const;
  pid_t id() const { return child_; }

 private:
  int end();  ///< its status as waitpid() tells it
  [[noreturn]] void throw_why_it_ended(const DecodeRequest& request);

  mutable std::mutex mutex_;
  pid_t owner_, child_ = 0;
  int socket_ = -1, memory_ = -1;
  bool ended_ = false;
};

}  // namespace ringsplat::detail
