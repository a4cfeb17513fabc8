// The only source that includes Beast, which takes half a minute to compile.
#include "serve/web_server.hpp"

#include <atomic>
#include <csignal>
#include <thread>

#include "base/log.hpp"
#include "base/process.hpp"
#include "ringsplat/base/error.hpp"
#include "serve/web_connections.hpp"

namespace ringsplat::serve {

using namespace web;

namespace {

/// "[::1]:8080" or "127.0.0.1:8080".
std::string host_and_port(const asio::ip::address& address, int port) {
  const std::string text = address.to_string();
  return fmt::format("{}:{}", address.is_v6() ? "[" + text + "]" : text, port);
}

}  // namespace

struct WebServer::Impl {
  Impl(const ServerOptions& options, ServerEvents& events)
      : acceptor_(shared_.io), pause_(shared_.io), signals_(shared_.io) {
    shared_.events = &events;
    error_code error;
    const asio::ip::address address = asio::ip::make_address(options.address, error);
    if (error)
      throw InputError(fmt::format("--bind {} is no IP address", options.address),
                       "leave it out, or give for instance 0.0.0.0");
    if (options.port < 0 || options.port > 65535)
      throw InputError(fmt::format("there is no port {}", options.port), "0 takes any that is free");
    const tcp::endpoint endpoint(address, static_cast<unsigned short>(options.port));
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (error)
      throw InputError(fmt::format("the server cannot listen at {}: {}", host_and_port(address, options.port),
                                   error.message()),
                       "choose another --port, 0 for any free one, or an own address by --bind");
    const int port = acceptor_.local_endpoint().port();
    const std::string machine = host_name();
    name_ = address.is_unspecified() ? fmt::format("{}:{}", machine.empty() ? "localhost" : machine, port)
                                     : host_and_port(address, port);
    std::vector<std::string> hosts{fmt::format("127.0.0.1:{}", port), fmt::format("localhost:{}", port),
                                   fmt::format("[::1]:{}", port), name_};
    hosts.insert(hosts.end(), options.allowed_hosts.begin(), options.allowed_hosts.end());
    shared_.access = {options.token.empty() ? make_token() : options.token, std::move(hosts),
                      options.allowed_origins};
    successor_ = options;
    successor_.port = port;
    successor_.token = shared_.access.token;
    shared_.frame_ancestors = frame_ancestors(options.allowed_frames);
    accept();
    if (!options.takes_signals) return;
    signals_.add(SIGINT);
    signals_.add(SIGTERM);
    wait_for_signal();
  }

  void end(const std::shared_ptr<const std::string>& last_text) {
    if (std::exchange(shared_.ending, true)) return;
    error_code ignored;
    acceptor_.close(ignored);
    for (const auto& [id, client] : shared_.clients) {
      client->send(false, last_text);
      client->close();
    }
    last_moment_ = Clock::now() + std::chrono::seconds(1);
    stop_soon();
  }

  void accept() {
    acceptor_.async_accept([this](error_code error, tcp::socket socket) {
      if (shared_.ending || error == asio::error::operation_aborted) return;
      if (error) {  // no descriptors left, perhaps
        pause_.expires_after(std::chrono::milliseconds(100));
        pause_.async_wait([this](error_code) {
          if (!shared_.ending) accept();
        });
        return;
      }
      if (shared_.visitors.size() >= limits.visitors) shared_.visitors.front()->give_way();
      socket.set_option(tcp::no_delay(true), error);  // it works without
      std::make_shared<Visitor>(shared_, std::move(socket))->read();
      accept();
    });
  }

  /// When all clients have closed, or there is no more time for that.
  void stop_soon() {
    if (shared_.clients.empty() || Clock::now() >= last_moment_) return shared_.io.stop();
    pause_.expires_after(std::chrono::milliseconds(10));
    pause_.async_wait([this](error_code) { stop_soon(); });
  }

  void wait_for_signal() {
    signals_.async_wait([this](error_code error, int number) {
      if (error) return;
      shared_.events->signalled(number);
      wait_for_signal();
    });
  }

  Shared shared_;
  std::string name_;
  ServerOptions successor_;
  std::atomic<bool> ends_ = false;  ///< end() was called
  tcp::acceptor acceptor_;
  asio::steady_timer pause_;
  Clock::time_point last_moment_;
  asio::signal_set signals_;
  std::thread thread_;
};

WebServer::WebServer(const ServerOptions& options, ServerEvents& events)
    : impl_(std::make_unique<Impl>(options, events)) {}

WebServer::~WebServer() { stop(); }

void WebServer::stop() {
  if (!impl_->ends_) impl_->shared_.io.stop();  // otherwise end() sees to it
  if (impl_->thread_.joinable()) impl_->thread_.join();
  impl_->shared_.events = nullptr;
  error_code ignored;
  impl_->signals_.clear(ignored);  // from now on they do what they do without a server
}

void WebServer::start() {
  impl_->thread_ = std::thread([&io = impl_->shared_.io] {
    while (true) {
      try {
        io.run();
        return;
      } catch (const std::exception& e) {
        log_error("the viewer's server: {}", e.what());
      }
    }
  });
}

std::string WebServer::url() const {
  return fmt::format("http://{}/#{}", impl_->name_, impl_->shared_.access.token);
}

ServerOptions WebServer::successor() const { return impl_->successor_; }

void WebServer::send(ClientId id, bool binary, std::shared_ptr<const std::string> bytes) {
  asio::post(impl_->shared_.io, [&clients = impl_->shared_.clients, id, binary, bytes = std::move(bytes)] {
    if (const auto client = clients.find(id); client != clients.end()) client->second->send(binary, bytes);
  });
}

void WebServer::end(std::string last_text) {
  impl_->ends_ = true;  // at once: stop() may come before it is done
  asio::post(impl_->shared_.io,
             [this, last = std::make_shared<const std::string>(std::move(last_text))] { impl_->end(last); });
}

}  // namespace ringsplat::serve
