#include "formats/decode/messages.hpp"

#include <sys/socket.h>

#include <array>
#include <cerrno>

namespace ringsplat::detail {
namespace {

bool send_all(int socket, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes = bytes.subspan(std::size_t(sent));
  }
  return true;
}

bool receive_all(int socket, std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const auto got = ::recv(socket, bytes.data(), bytes.size(), 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes = bytes.subspan(std::size_t(got));
  }
  return true;
}

}  // namespace

bool send_message(int socket, std::span<const std::byte> message) {
  Bytes length;
  append(length, std::uint64_t(message.size()));
  return send_all(socket, length) && send_all(socket, message);
}

std::optional<Bytes> receive_message(int socket) {
  std::array<std::byte, sizeof(std::uint64_t)> length{};
  std::uint64_t bytes = 0;
  std::size_t at = 0;
  constexpr std::uint64_t most = std::uint64_t{1} << 30;  // facts of all files that a folder may have
  if (!receive_all(socket, length) || !take(length, at, bytes) || bytes > most) return {};
  Bytes message(static_cast<std::size_t>(bytes));
  if (!receive_all(socket, message)) return {};
  return message;
}

}  // namespace ringsplat::detail
