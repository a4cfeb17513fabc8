#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace ringsplat::serve {

/// A connection of a page, from 1; never used again.
using ClientId = std::uint64_t;

struct ServerOptions {
  std::string address = "127.0.0.1";
  int port = 0;  ///< 0: any
  std::vector<std::string> allowed_hosts, allowed_origins;
  /// Pages that may show the page in a frame, as origins; the port may be "*". None: no page may.
  std::vector<std::string> allowed_frames = {};
  bool take_signals = false;  ///< SIGINT and SIGTERM become ServerEvents::signalled
};

/// What a client may use up.
struct ServerLimits {
  int pages = 32;                                    ///< with the token; one more is told 503
  std::size_t visitors = 64;                         ///< without: for one more the oldest gives way
  std::size_t message_bytes = std::size_t{1} << 16;  ///< of one that a client sends
  std::size_t header_bytes = std::size_t{1} << 13;
  /// A client that leaves more than this unread, behind the message that is being sent, is cut off when there
  /// is more for it.
  std::size_t unsent_bytes = std::size_t{1} << 25;
  double messages_per_second = 500;   ///< more are read later
  std::chrono::seconds patience{10};  ///< with half a request
  std::chrono::seconds silence{60};  ///< of a client that is pinged; pings wait behind what a slow line holds
};

/// Called on the server's thread; must return soon and throw nothing.
struct ServerEvents {
  std::function<void(ClientId)> opened;
  std::function<void(ClientId, std::string&& text)> received;
  std::function<void(ClientId)> refused;  ///< the client sent a message that is no text
  std::function<void(ClientId)> closed;   ///< once for each that was opened
  std::function<void(int signal)> signalled;
};

/// Serves the page's files and WebSocket connections by one thread of its own, which never calls MPI. All
/// functions may be called by any thread.
class WebServer {
 public:
  /// Binds the port. Throws InputError when the address or port cannot be had.
  WebServer(const ServerOptions& options, ServerEvents events, const ServerLimits& limits = {});
  /// Closes all connections at once.
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// From now on there are events.
  void start();
  int port() const;
  /// The page's, with the token, which gives whoever reads it the right to connect.
  std::string url() const;

  /// To a client that is gone: nothing happens. Clients may share the bytes.
  void send_text(ClientId client, std::shared_ptr<const std::string> text);
  void send_binary(ClientId client, std::shared_ptr<const std::string> bytes);
  /// Sends a last text to all clients, closes the connections, and takes no more. Returns at once; the
  /// destructor waits up to a second for slow clients.
  void end(const std::string& last_text);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ringsplat::serve
