#pragma once
#include <array>

#include "serve/page_encoding.hpp"
#include "serve/page_files.hpp"
#include "serve/web_client.hpp"

namespace ringsplat::serve::web {

inline const char* content_type(std::string_view name) {
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

inline const PageFile* find_page_file(std::string_view target) {
  target = target.substr(0, target.find_first_of("?#"));
  if (target.starts_with("/")) target.remove_prefix(1);
  if (target.empty()) target = "index.html";
  for (const PageFile& file : page_files())
    if (file.name == target) return &file;
  return nullptr;
}

/// A connection while it asks for files, until it becomes a page's WebSocket.
class Visitor : public std::enable_shared_from_this<Visitor> {
 public:
  Visitor(Shared& shared, tcp::socket&& socket)
      : shared_(shared),
        listed_(shared.visitors.insert(shared.visitors.end(), this)),
        stream_(std::move(socket)) {}
  ~Visitor() { leave_list(); }
  Visitor(const Visitor&) = delete;
  Visitor& operator=(const Visitor&) = delete;

  /// Ends the connection, so that strangers who say nothing keep nobody out.
  void give_way() {
    leave_list();
    stream_.close();
  }

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
    const bool alive = request.keep_alive();
    const std::string_view host = view(request[http::field::host]);
    if (request.count(http::field::host) != 1 || !shared_.access->host_allowed(host))
      return reply(http::status::misdirected_request, "text/plain",
                   "this server is not known by that name; --allow-host adds one\n", false);
    if (websocket::is_upgrade(request)) return upgrade(host);
    if (request.method() != http::verb::get && request.method() != http::verb::head)
      return reply(http::status::method_not_allowed, "text/plain", "only GET\n", false);
    if (view(request.target()) == "/token") return judge_token(request);
    const PageFile* const file = find_page_file(view(request.target()));
    if (file == nullptr)
      return reply(http::status::not_found, "text/plain", "there is no such file\n", alive);
    if (file->name == "index.html") return reply_with_page(file->bytes, alive);
    reply(http::status::ok, content_type(file->name), file->bytes, alive);
  }

  /// The page is asked for again only where it has changed, and compressed where that is understood.
  void reply_with_page(std::string_view html, bool alive) {
    const auto& request = parser_->get();
    const bool known =
        view(request[http::field::if_none_match]).find(shared_.page_tag) != std::string_view::npos;
    const bool packed = view(request[http::field::accept_encoding]).find("gzip") != std::string_view::npos;
    http::fields more;
    more.set(http::field::etag, shared_.page_tag);
    more.set(http::field::cache_control, "no-cache");
    more.set(http::field::vary, "Accept-Encoding");
    if (known) return reply(http::status::not_modified, content_type(".html"), "", alive, more);
    if (packed) more.set(http::field::content_encoding, "gzip");
    reply(http::status::ok, content_type(".html"), packed ? shared_.packed_page : html, alive, more);
  }

  /// A page learns nothing from a WebSocket that is refused: it asks here whether its token was wrong.
  void judge_token(const http::request<http::empty_body>& request) {
    if (shared_.access->is_token(view(request["Ringsplat-Token"])))
      reply(http::status::no_content, "text/plain", "", request.keep_alive());
    else
      reply(http::status::forbidden, "text/plain", "the token is missing or wrong\n", request.keep_alive());
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
    if (shared_.pages >= shared_.limits.pages)
      return reply(http::status::service_unavailable, "text/plain", "too many pages\n", false);
    stream_.expires_never();
    std::make_shared<Client>(shared_, stream_.release_socket(), Place(shared_))->accept(parser_->release());
  }

  /// `more`: header fields besides those of all answers, or in their place.
  void reply(http::status status, const char* type, std::string_view body, bool keep_alive,
             const http::fields& more = {}) {
    const unsigned version = parser_ ? parser_->get().version() : 11;
    const bool head = parser_ && parser_->get().method() == http::verb::head;
    auto response = std::make_shared<http::response<http::string_body>>(status, version);
    response->set(http::field::content_type, type);
    response->set("Content-Security-Policy",
                  "default-src 'none'; script-src 'self' " + policy_source(page_hashes().script) +
                      "; style-src 'self' " + policy_source(page_hashes().style) +
                      "; img-src 'self' blob: data:; connect-src 'self'; frame-ancestors " +
                      shared_.frame_ancestors + "; base-uri 'none'; form-action 'none'");
    response->set("X-Content-Type-Options", "nosniff");
    response->set("Referrer-Policy", "no-referrer");
    response->set("Cross-Origin-Resource-Policy", "same-origin");
    response->set("Cross-Origin-Opener-Policy", "same-origin");
    response->set(http::field::cache_control, "no-store");
    for (const auto& field : more) response->set(field.name(), field.value());
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

  void leave_list() {
    if (listed_) shared_.visitors.erase(*std::exchange(listed_, std::nullopt));
  }

  Shared& shared_;
  std::optional<std::list<Visitor*>::iterator> listed_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>> parser_;
};

}  // namespace ringsplat::serve::web
