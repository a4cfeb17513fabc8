#pragma once
// The web server's connections, which only web_server.cpp includes: Beast takes half a minute to compile.
#include <algorithm>
#include <chrono>
#include <deque>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

// Asio of Boost 1.74 uses std::exchange without including <utility>.
#include <boost/asio.hpp>
#include <boost/beast.hpp>

#include "serve/access.hpp"
#include "serve/web_server.hpp"

namespace ringsplat::serve::web {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using beast::error_code;
using Clock = std::chrono::steady_clock;

inline std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }
inline beast::string_view view(std::string_view text) { return {text.data(), text.size()}; }

class Client;
class Visitor;

/// What a client may use up.
struct ServerLimits {
  int pages = 32;                                    ///< with the token; one more is told 503
  std::size_t visitors = 64;                         ///< without: for one more the oldest gives way
  std::size_t message_bytes = std::size_t{1} << 16;  ///< of one that a client sends
  std::size_t header_bytes = std::size_t{1} << 13;
  /// A client that leaves more than this unread, behind the message that is being sent, is cut off when there
  /// is more for it. The PNG of two large pictures fits.
  std::size_t unsent_bytes = std::size_t{1} << 26;
  double messages_per_second = 500;   ///< more are read later
  std::chrono::seconds patience{10};  ///< with half a request
  std::chrono::seconds silence{60};  ///< of a client that is pinged; pings wait behind what a slow line holds
};

constexpr ServerLimits limits;

/// What all connections share; only the server's thread uses it.
struct Shared {
  ServerEvents* events = nullptr;  ///< none once the server goes
  Access access;
  std::string frame_ancestors;          ///< a list of the Content-Security-Policy
  std::map<ClientId, Client*> clients;  ///< that are open; each leaves the map when it goes
  int pages = 0;                        ///< connections that have shown the token
  /// All others, in the order in which they came; each leaves the list when it goes.
  std::list<Visitor*> visitors;
  ClientId last_client = 0;
  bool ending = false;
  asio::io_context io;  ///< goes first, as it holds connections; told of one thread it would reorder posts
};

/// A page's WebSocket connection.
class Client : public std::enable_shared_from_this<Client> {
 public:
  Client(Shared& shared, tcp::socket&& socket)
      : shared_(shared), stream_(std::move(socket)), timer_(shared.io), id_(++shared.last_client) {
    ++shared.pages;
  }
  ~Client() {
    --shared_.pages;
    if (!open_) return;
    shared_.clients.erase(id_);
    if (shared_.events != nullptr) shared_.events->closed(id_);
  }

  void accept(http::request<http::empty_body> request) {
    stream_.read_message_max(limits.message_bytes);
    // A large file is sent in fragments, between which pings can go: without their answers a slow client
    // would be taken for a dead one.
    stream_.auto_fragment(true);
    stream_.write_buffer_bytes(std::size_t{1} << 16);
    stream_.set_option(websocket::stream_base::timeout{limits.patience, limits.silence,
                                                       /*keep_alive_pings*/ true});
    stream_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
      response.set(http::field::sec_websocket_protocol, view(subprotocol));
    }));
    auto kept = std::make_shared<http::request<http::empty_body>>(std::move(request));
    stream_.async_accept(*kept, [self = shared_from_this(), kept](error_code error) {
      if (error || self->shared_.ending) return;
      self->open_ = true;
      self->shared_.clients[self->id_] = self.get();
      self->shared_.events->opened(self->id_);
      self->read();
    });
  }

  void send(bool binary, std::shared_ptr<const std::string> bytes) {
    if (cut_off_) return;
    if (waiting_ > limits.unsent_bytes) return cut_off();
    if (!outgoing_.empty()) waiting_ += bytes->size();
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
      shared_.events->received(id_, beast::buffers_to_string(buffer_.data()));
    else
      shared_.events->refused(id_);
    buffer_.consume(buffer_.size());
    // Does not read on while the client sends too much; TCP then stops it.
    const auto now = Clock::now();
    constexpr double rate = limits.messages_per_second;
    allowance_ =
        std::min(rate, allowance_ + rate * std::chrono::duration<double>(now - counted_).count()) - 1;
    counted_ = now;
    if (allowance_ > 0) return read();
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
                          self->outgoing_.pop_front();
                          if (!self->outgoing_.empty()) {
                            self->waiting_ -= self->outgoing_.front().bytes->size();
                            self->write();
                          } else if (self->closing_) {
                            self->start_closing();
                          }
                        });
  }

  void start_closing() {
    stream_.async_close(websocket::close_code::going_away, [self = shared_from_this()](error_code) {});
  }

  Shared& shared_;
  websocket::stream<beast::tcp_stream> stream_;
  asio::steady_timer timer_;
  beast::flat_buffer buffer_;
  std::deque<Outgoing> outgoing_;  ///< the first is being written
  std::size_t waiting_ = 0;        ///< bytes behind the first
  ClientId id_;
  double allowance_ = limits.messages_per_second;  ///< messages that may be read now
  Clock::time_point counted_ = Clock::now();
  bool open_ = false, closing_ = false, cut_off_ = false;
};

/// A connection while it asks for the page, until it becomes a page's WebSocket.
class Visitor : public std::enable_shared_from_this<Visitor> {
 public:
  Visitor(Shared& shared, tcp::socket&& socket) : shared_(shared), stream_(std::move(socket)) {
    shared.visitors.push_back(this);
  }
  ~Visitor() { shared_.visitors.remove(this); }

  /// Ends the connection, so that strangers who say nothing keep nobody out.
  void give_way() {
    shared_.visitors.remove(this);
    stream_.close();
  }

  void read() {
    parser_.header_limit(static_cast<std::uint32_t>(limits.header_bytes));
    stream_.expires_after(limits.patience);
    http::async_read(stream_, buffer_, parser_,
                     [self = shared_from_this()](error_code error, std::size_t) { self->take(error); });
  }

 private:
  void take(error_code error) {
    if (error == http::error::end_of_stream || error == beast::error::timeout ||
        error == asio::error::operation_aborted || error == asio::error::connection_reset)
      return;
    if (error) return reply(http::status::bad_request, "this is no request\n");
    const auto& request = parser_.get();
    const std::string_view host = view(request[http::field::host]);
    if (request.count(http::field::host) != 1 || !shared_.access.host_allowed(host))
      return reply(http::status::misdirected_request,
                   "this server is not known by that name; --allow-host adds one\n");
    if (websocket::is_upgrade(request)) return upgrade(host);
    if (request.method() != http::verb::get && request.method() != http::verb::head)
      return reply(http::status::method_not_allowed, "only GET\n");
    std::string_view target = view(request.target());
    // A page learns nothing from a WebSocket that is refused: it asks here whether its token was wrong.
    if (target == "/token")
      return shared_.access.is_token(view(request["Ringsplat-Token"]))
                 ? reply(http::status::no_content, "")
                 : reply(http::status::forbidden, "the token is missing or wrong\n");
    target = target.substr(0, target.find_first_of("?#"));
    if (target != "/" && target != "/index.html")
      return reply(http::status::not_found, "there is no such file\n");
    // The page is asked for again only where it has changed, and compressed where that is understood.
    const std::string tag = '"' + std::string(page_file.hash) + '"';
    const bool known = view(request[http::field::if_none_match]).find(tag) != std::string_view::npos;
    const bool packed = view(request[http::field::accept_encoding]).find("gzip") != std::string_view::npos;
    http::fields more;
    more.set(http::field::content_type, "text/html; charset=utf-8");
    more.set(http::field::etag, tag);
    more.set(http::field::cache_control, "no-cache");
    more.set(http::field::vary, "Accept-Encoding");
    if (known) return reply(http::status::not_modified, "", more);
    if (packed) more.set(http::field::content_encoding, "gzip");
    reply(http::status::ok, packed ? page_file.gzipped : page_file.html, more);
  }

  void upgrade(std::string_view host) {
    const auto& request = parser_.get();
    const std::string_view target = view(request.target());
    if (target.substr(0, target.find('?')) != "/ws")
      return reply(http::status::not_found, "the page connects to ws\n");
    if (request.count(http::field::origin) != 1 ||
        !shared_.access.origin_allowed(view(request[http::field::origin]), host))
      return reply(http::status::forbidden, "this origin may not connect; --allow-origin adds one\n");
    if (request.count(http::field::sec_websocket_protocol) != 1 ||
        !shared_.access.may_connect(view(request[http::field::sec_websocket_protocol])))
      return reply(http::status::forbidden, "the token is missing or wrong\n");
    if (shared_.pages >= limits.pages) return reply(http::status::service_unavailable, "too many pages\n");
    stream_.expires_never();
    std::make_shared<Client>(shared_, stream_.release_socket())->accept(parser_.release());
  }

  /// The only answer: a page needs no other, and its WebSocket is a connection of its own. `more`: header
  /// fields besides those of all answers, or in their place.
  void reply(http::status status, std::string_view body, const http::fields& more = {}) {
    const auto& request = parser_.get();
    auto response = std::make_shared<http::response<http::string_body>>(status, request.version());
    response->set(http::field::content_type, "text/plain");
    response->set("Content-Security-Policy",
                  "default-src 'none'; script-src 'self' " + policy_source(page_file.script_hash) +
                      "; style-src 'self' " + policy_source(page_file.style_hash) +
                      "; img-src 'self' blob: data:; connect-src 'self'; frame-ancestors " +
                      shared_.frame_ancestors + "; base-uri 'none'; form-action 'none'");
    response->set("X-Content-Type-Options", "nosniff");
    response->set("Referrer-Policy", "no-referrer");
    response->set("Cross-Origin-Resource-Policy", "same-origin");
    response->set("Cross-Origin-Opener-Policy", "same-origin");
    response->set(http::field::cache_control, "no-store");
    for (const auto& field : more) response->set(field.name(), field.value());
    response->body() = std::string(body);
    response->keep_alive(false);
    response->prepare_payload();
    if (request.method() == http::verb::head) response->body().clear();
    stream_.expires_after(limits.patience);
    http::async_write(stream_, *response,
                      [self = shared_from_this(), response](error_code error, std::size_t) {
                        self->stream_.socket().shutdown(tcp::socket::shutdown_send, error);
                      });
  }

  Shared& shared_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
};

}  // namespace ringsplat::serve::web
