// The only source that includes Beast, which takes half a minute to compile.
#include "serve/web_server.hpp"

#include <unistd.h>

#include <array>
#include <csignal>
#include <deque>
#include <map>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

// Asio of Boost 1.74 uses std::exchange without including <utility>.
#include <fmt/format.h>
#include <boost/asio.hpp>
#include <boost/beast.hpp>

#include "base/log.hpp"
#include "ringsplat/base/error.hpp"
#include "serve/access.hpp"
#include "serve/page_files.hpp"

namespace ringsplat::serve {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using beast::error_code;
using Clock = std::chrono::steady_clock;

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }
beast::string_view view(std::string_view text) { return {text.data(), text.size()}; }

const char* content_type(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, const char*>, 5> types{
      {{".html", "text/html; charset=utf-8"},
       {".js", "text/javascript; charset=utf-8"},
       {".css", "text/css; charset=utf-8"},
       {".svg", "image/svg+xml"},
       {".json", "application/json"}}};
  for (const auto& [ending, type] : types)
    if (name.ends_with(ending)) return type;
  return "application/octet-stream";
}

const PageFile* find_page_file(std::string_view target) {
  target = target.substr(0, target.find_first_of("?#"));
  if (target.starts_with("/")) target.remove_prefix(1);
  if (target.empty()) target = "index.html";
  for (const PageFile& file : page_files())
    if (file.name == target) return &file;
  return nullptr;
}

/// "[::1]:8080" or "127.0.0.1:8080".
std::string host_and_port(const asio::ip::address& address, int port) {
  const std::string text = address.to_string();
  return fmt::format("{}:{}", address.is_v6() ? "[" + text + "]" : text, port);
}

std::string machine_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "localhost";
}

class Client;

/// What all connections share; only the server's thread uses it.
struct Shared {
  ServerLimits limits;
  ServerEvents events;
  std::optional<Access> access;
  std::map<ClientId, std::weak_ptr<Client>> clients;
  int connections = 0;
  ClientId last_client = 0;
  bool ending = false;
  asio::io_context io{1};  ///< goes first, with handlers that hold connections
};

/// A connection's place among those that are allowed.
class Place {
 public:
  explicit Place(Shared& shared) : shared_(&shared) { ++shared.connections; }
  ~Place() {
    if (shared_ != nullptr) --shared_->connections;
  }
  Place(Place&& other) noexcept : shared_(std::exchange(other.shared_, nullptr)) {}
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;
  Place& operator=(Place&&) = delete;

 private:
  Shared* shared_;
};

/// A page's WebSocket connection.
class Client : public std::enable_shared_from_this<Client> {
 public:
  Client(Shared& shared, tcp::socket&& socket, Place&& place)
      : shared_(shared),
        place_(std::move(place)),
        stream_(std::move(socket)),
        timer_(shared.io),
        id_(++shared.last_client),
        allowance_(shared.limits.messages_per_second) {}
  ~Client() {
    if (!open_) return;
    shared_.clients.erase(id_);
    shared_.events.closed(id_);
  }

  void accept(http::request<http::empty_body> request) {
    stream_.read_message_max(shared_.limits.message_bytes);
    stream_.auto_fragment(false);
    stream_.set_option(websocket::stream_base::timeout{shared_.limits.patience, 2 * shared_.limits.patience,
                                                       /*keep_alive_pings*/ true});
    stream_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
      response.set(http::field::sec_websocket_protocol, view(subprotocol));
    }));
    auto kept = std::make_shared<http::request<http::empty_body>>(std::move(request));
    stream_.async_accept(*kept, [self = shared_from_this(), kept](error_code error) {
      if (error || self->shared_.ending) return;
      self->open_ = true;
      self->shared_.clients[self->id_] = self;
      self->shared_.events.opened(self->id_);
      self->read();
    });
  }

  void send(bool binary, std::shared_ptr<const std::string> bytes) {
    if (cut_off_) return;
    if (unsent_ > shared_.limits.unsent_bytes) {
      cut_off();
      return;
    }
    unsent_ += bytes->size();
    outgoing_.push_back({binary, std::move(bytes)});
    if (outgoing_.size() == 1) write();
  }

  /// After what is still to be sent.
  void close() {
    closing_ = true;
    if (outgoing_.empty()) start_closing();
  }

  void cut_off() {
    cut_off_ = true;
    error_code ignored;
    beast::get_lowest_layer(stream_).socket().close(ignored);
    timer_.cancel();
  }

 private:
  struct Outgoing {
    bool binary;
    std::shared_ptr<const std::string> bytes;
  };

  void read() {
    stream_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (!error && !self->cut_off_) self->take();
    });
  }

  void take() {
    if (stream_.got_text())
      shared_.events.received(id_, beast::buffers_to_string(buffer_.data()));
    else
      shared_.events.refused(id_);
    buffer_.consume(buffer_.size());
    wait_until_allowed();
  }

  /// Does not read on while the client sends too much; TCP then stops it.
  void wait_until_allowed() {
    const auto now = Clock::now();
    const double rate = shared_.limits.messages_per_second;
    allowance_ =
        std::min(rate, allowance_ + rate * std::chrono::duration<double>(now - counted_).count()) - 1;
    counted_ = now;
    if (allowance_ > 0) {
      read();
      return;
    }
    timer_.expires_after(std::chrono::milliseconds(20));
    timer_.async_wait([self = shared_from_this()](error_code error) {
      if (!error && !self->cut_off_) self->read();
    });
  }

  void write() {
    stream_.binary(outgoing_.front().binary);
    stream_.async_write(asio::buffer(*outgoing_.front().bytes),
                        [self = shared_from_this()](error_code error, std::size_t) {
                          if (error || self->cut_off_) return;
                          self->unsent_ -= self->outgoing_.front().bytes->size();
                          self->outgoing_.pop_front();
                          if (!self->outgoing_.empty())
                            self->write();
                          else if (self->closing_)
                            self->start_closing();
                        });
  }

  void start_closing() {
    stream_.async_close(websocket::close_code::going_away, [self = shared_from_this()](error_code) {});
  }

  Shared& shared_;
  Place place_;
  websocket::stream<beast::tcp_stream> stream_;
  asio::steady_timer timer_;
  beast::flat_buffer buffer_;
  std::deque<Outgoing> outgoing_;  ///< the first is being written
  std::size_t unsent_ = 0;
  ClientId id_;
  double allowance_;  ///< messages that may be read now
  Clock::time_point counted_ = Clock::now();
  bool open_ = false, closing_ = false, cut_off_ = false;
};

/// A connection while it asks for files, until it becomes a page's WebSocket.
class Visitor : public std::enable_shared_from_this<Visitor> {
 public:
  /// `one_too_many`: it is told so, whatever it asks.
  Visitor(Shared& shared, tcp::socket&& socket, bool one_too_many)
      : shared_(shared), one_too_many_(one_too_many), place_(shared), stream_(std::move(socket)) {}

  void read() {
    parser_.emplace();
    parser_->header_limit(static_cast<std::uint32_t>(shared_.limits.header_bytes));
    stream_.expires_after(shared_.limits.patience);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](error_code error, std::size_t) { self->take(error); });
  }

 private:
  void take(error_code error) {
    if (error == http::error::end_of_stream || error == beast::error::timeout ||
        error == asio::error::operation_aborted || error == asio::error::connection_reset)
      return;
    if (error) return reply(http::status::bad_request, "text/plain", "this is no request\n", false);
    answer(parser_->get());
  }

  void answer(const http::request<http::empty_body>& request) {
    if (one_too_many_)
      return reply(http::status::service_unavailable, "text/plain", "too many connections\n", false);
    const bool alive = request.keep_alive();
    const std::string_view host = view(request[http::field::host]);
    if (request.count(http::field::host) != 1 || !shared_.access->host_allowed(host))
      return reply(http::status::misdirected_request, "text/plain",
                   "this server is not known by that name; --allow-host adds one\n", false);
    if (websocket::is_upgrade(request)) return upgrade(host);
    if (request.method() != http::verb::get && request.method() != http::verb::head)
      return reply(http::status::method_not_allowed, "text/plain", "only GET\n", false);
    const PageFile* const file = find_page_file(view(request.target()));
    if (file == nullptr)
      return reply(http::status::not_found, "text/plain", "there is no such file\n", alive);
    reply(http::status::ok, content_type(file->name), file->bytes, alive);
  }

  void upgrade(std::string_view host) {
    const auto& request = parser_->get();
    const std::string_view target = view(request.target());
    if (target.substr(0, target.find('?')) != "/ws")
      return reply(http::status::not_found, "text/plain", "the page connects to ws\n", false);
    if (request.count(http::field::origin) != 1 ||
        !shared_.access->origin_allowed(view(request[http::field::origin]), host))
      return reply(http::status::forbidden, "text/plain",
                   "this origin may not connect; --allow-origin adds one\n", false);
    if (request.count(http::field::sec_websocket_protocol) != 1 ||
        !shared_.access->may_connect(view(request[http::field::sec_websocket_protocol])))
      return reply(http::status::forbidden, "text/plain", "the token is missing or wrong\n", false);
    stream_.expires_never();
    std::make_shared<Client>(shared_, stream_.release_socket(), std::move(place_))
        ->accept(parser_->release());
  }

  void reply(http::status status, const char* type, std::string_view body, bool keep_alive) {
    const unsigned version = parser_ ? parser_->get().version() : 11;
    const bool head = parser_ && parser_->get().method() == http::verb::head;
    auto response = std::make_shared<http::response<http::string_body>>(status, version);
    response->set(http::field::content_type, type);
    response->set("Content-Security-Policy",
                  "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
                  "connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'");
    response->set("X-Content-Type-Options", "nosniff");
    response->set("Referrer-Policy", "no-referrer");
    response->set("Cross-Origin-Resource-Policy", "same-origin");
    response->set("Cross-Origin-Opener-Policy", "same-origin");
    response->set(http::field::cache_control, "no-store");
    response->body() = std::string(body);
    response->keep_alive(keep_alive);
    response->prepare_payload();
    if (head) response->body().clear();
    stream_.expires_after(shared_.limits.patience);
    http::async_write(stream_, *response,
                      [self = shared_from_this(), response](error_code error, std::size_t) {
                        if (error) return;
                        if (response->keep_alive())
                          self->read();
                        else
                          self->stream_.socket().shutdown(tcp::socket::shutdown_send, error);
                      });
  }

  Shared& shared_;
  const bool one_too_many_;
  Place place_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>> parser_;
};

}  // namespace

class WebServer::Impl {
 public:
  Impl(const ServerOptions& options, ServerEvents events, const ServerLimits& limits)
      : token_(make_token()), acceptor_(shared_.io), pause_(shared_.io) {
    shared_.limits = limits;
    shared_.events = std::move(events);
    bind(options);
    shared_.access.emplace(token_, hosts(options), options.allowed_origins);
    accept();
    if (options.take_signals) {
      signals_.emplace(shared_.io, SIGINT, SIGTERM);
      wait_for_signal();
    }
  }

  ~Impl() {
    asio::post(shared_.io, [this] {
      if (!shared_.ending) shared_.io.stop();  // otherwise end() has seen to it
    });
    if (thread_.joinable()) thread_.join();
    shared_.events.closed = [](ClientId) {};
  }

  void start() {
    thread_ = std::thread([this] { run(); });
  }

  int port() const { return port_; }
  std::string url() const { return fmt::format("http://{}/#{}", name_, token_); }

  void send(ClientId id, bool binary, std::shared_ptr<const std::string> bytes) {
    asio::post(shared_.io, [this, id, binary, bytes = std::move(bytes)] {
      const auto client = shared_.clients.find(id);
      if (client == shared_.clients.end()) return;
      if (const auto held = client->second.lock()) held->send(binary, bytes);
    });
  }

  void end(std::shared_ptr<const std::string> last_text) {
    asio::post(shared_.io, [this, last_text = std::move(last_text)] {
      if (std::exchange(shared_.ending, true)) return;
      error_code ignored;
      acceptor_.close(ignored);
      if (signals_) signals_->cancel(ignored);
      for (const auto& held : clients()) {
        held->send(false, last_text);
        held->close();
      }
      last_moment_ = Clock::now() + std::chrono::seconds(1);
      stop_soon();
    });
  }

 private:
  void bind(const ServerOptions& options) {
    error_code error;
    address_ = asio::ip::make_address(options.address, error);
    if (error)
      throw InputError(fmt::format("--bind {} is no IP address", options.address),
                       "leave it out, or give for instance 0.0.0.0");
    const tcp::endpoint endpoint(address_, static_cast<unsigned short>(options.port));
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    if (error)
      throw InputError(fmt::format("the server cannot listen at {}: {}",
                                   host_and_port(address_, options.port), error.message()),
                       "choose another --port; 0 takes any that is free");
    port_ = acceptor_.local_endpoint().port();
    name_ = address_.is_unspecified() ? fmt::format("{}:{}", machine_name(), port_)
                                      : host_and_port(address_, port_);
  }

  std::vector<std::string> hosts(const ServerOptions& options) const {
    std::vector<std::string> all{fmt::format("127.0.0.1:{}", port_), fmt::format("localhost:{}", port_),
                                 fmt::format("[::1]:{}", port_), name_};
    all.insert(all.end(), options.allowed_hosts.begin(), options.allowed_hosts.end());
    return all;
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
      welcome(std::move(socket));
      accept();
    });
  }

  void welcome(tcp::socket&& socket) {
    if (shared_.connections >= 2 * shared_.limits.connections) return;  // closes it
    error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    const bool one_too_many = shared_.connections >= shared_.limits.connections;
    std::make_shared<Visitor>(shared_, std::move(socket), one_too_many)->read();
  }

  std::vector<std::shared_ptr<Client>> clients() const {
    std::vector<std::shared_ptr<Client>> all;
    for (const auto& [id, client] : shared_.clients)
      if (auto held = client.lock()) all.push_back(std::move(held));
    return all;
  }

  /// When all clients have closed, or there is no more time for that.
  void stop_soon() {
    if (shared_.clients.empty() || Clock::now() >= last_moment_) {
      shared_.io.stop();
      return;
    }
    pause_.expires_after(std::chrono::milliseconds(10));
    pause_.async_wait([this](error_code) { stop_soon(); });
  }

  void wait_for_signal() {
    signals_->async_wait([this](error_code error, int number) {
      if (error) return;
      shared_.events.signalled(number);
      wait_for_signal();
    });
  }

  void run() {
    while (true) {
      try {
        shared_.io.run();
        return;
      } catch (const std::exception& e) {
        log_error("the viewer's server: {}", e.what());
      }
    }
  }

  Shared shared_;
  std::string token_, name_;
  asio::ip::address address_;
  int port_ = 0;
  tcp::acceptor acceptor_;
  asio::steady_timer pause_;
  Clock::time_point last_moment_;
  std::optional<asio::signal_set> signals_;
  std::thread thread_;
};

WebServer::WebServer(const ServerOptions& options, ServerEvents events, const ServerLimits& limits)
    : impl_(std::make_unique<Impl>(options, std::move(events), limits)) {}
WebServer::~WebServer() = default;

void WebServer::start() { impl_->start(); }
int WebServer::port() const { return impl_->port(); }
std::string WebServer::url() const { return impl_->url(); }

void WebServer::send_text(ClientId client, std::shared_ptr<const std::string> text) {
  impl_->send(client, false, std::move(text));
}

void WebServer::send_binary(ClientId client, std::shared_ptr<const std::string> bytes) {
  impl_->send(client, true, std::move(bytes));
}

void WebServer::end(const std::string& last_text) {
  impl_->end(std::make_shared<const std::string>(last_text));
}

}  // namespace ringsplat::serve
