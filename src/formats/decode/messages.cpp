#include "formats/decode/messages.hpp"

#include <sys/socket.h>

#include <cerrno>

namespace ringsplat::detail {
namespace {

/// By calls of send() or recv(), of which each may do a part.
template <class Buffer>
bool pass_all(ssize_t (*call)(int, Buffer*, std::size_t, int), int socket, std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const auto passed = call(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (passed < 0 && errno == EINTR) continue;
    if (passed <= 0) return false;
    bytes = bytes.subspan(std::size_t(passed));
  }
  return true;
}

}  // namespace

bool send_message(int socket, Bytes message) {
  std::uint64_t bytes = message.size();
  return pass_all(::send, socket, std::as_writable_bytes(std::span(&bytes, 1))) &&
         pass_all(::send, socket, message);
}

std::optional<Bytes> receive_message(int socket) {
  std::uint64_t bytes = 0;
  constexpr std::uint64_t most = std::uint64_t{1} << 30;  // facts of all files that a folder may have
  if (!pass_all(::recv, socket, std::as_writable_bytes(std::span(&bytes, 1))) || bytes > most) return {};
  Bytes message(static_cast<std::size_t>(bytes));
  if (!pass_all(::recv, socket, message)) return {};
  return message;
}

}  // namespace ringsplat::detail
