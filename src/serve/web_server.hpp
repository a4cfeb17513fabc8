#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace ringsplat::serve {

/// A connection of a page, from 1; never used again.
using ClientId = std::uint64_t;

struct ServerOptions {
  std::string address = "127.0.0.1";
  int port = 0;  ///< 0: any
  std::vector<std::string> allowed_hosts = {}, allowed_origins = {};
  /// Pages that may show the page in a frame, as origins; the port may be "*". None: no page may.
  std::vector<std::string> allowed_frames = {};
  bool takes_signals = true;  ///< else SIGINT and SIGTERM are left to the program
  std::string token = {};     ///< of 128 bits; empty: a new one
};

/// Called on the server's thread; must return soon and throw nothing.
class ServerEvents {
 public:
  virtual void opened(ClientId client) = 0;
  virtual void received(ClientId client, const std::string& text) = 0;
  virtual void refused(ClientId client) = 0;  ///< the client sent a message that is no text
  virtual void closed(ClientId client) = 0;   ///< once for each that was opened
  virtual void signalled(int number) = 0;     ///< SIGINT or SIGTERM

 protected:
  ~ServerEvents() = default;
};

/// Serves the page's files and WebSocket connections by one thread of its own, which never calls MPI. All
/// functions may be called by any thread.
class WebServer {
 public:
  /// Binds the port. `events` must outlive this. Throws InputError when the address or port cannot be had.
  WebServer(const ServerOptions& options, ServerEvents& events);
  /// Closes all connections at once, or waits for what end() began.
  ~WebServer();
  /// As the destructor.
  void stop();

  /// From now on there are events.
  void start();
  /// The page's, with the token, which gives whoever reads it the right to connect.
  std::string url() const;

  /// For a server in this one's place, to which its pages come back.
  ServerOptions successor() const;

  /// To a client that is gone: nothing happens. Clients may share the bytes.
  void send(ClientId client, bool binary, std::shared_ptr<const std::string> bytes);
  void send_text(ClientId client, std::string text) {
    send(client, false, std::make_shared<const std::string>(std::move(text)));
  }
  /// Sends a last text to all clients, closes the connections, and takes no more. Returns at once; the
  /// destructor, or stop(), waits up to a second for slow clients. Until then signals are still events.
  void end(std::string last_text);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ringsplat::serve
