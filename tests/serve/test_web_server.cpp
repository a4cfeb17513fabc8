#include "serve/web_server.hpp"

#include <thread>
#include <utility>

// Asio of Boost 1.74 uses std::exchange without including <utility>.
#include <boost/asio.hpp>

#include "support/catch.hpp"

using namespace ringsplat::serve;
using boost::asio::ip::tcp;

namespace {

/// Says something to each client, and lets another thread say more before it returns.
struct Talkers final : ServerEvents {
  void opened(ClientId client) override {
    server->send_text(client, "first");
    std::thread([&] { server->send_text(client, "second"); }).join();
  }
  void received(ClientId, const std::string&) override {}
  void refused(ClientId) override {}
  void closed(ClientId) override {}
  void signalled(int) override {}
  WebServer* server = nullptr;
};

/// A short text that the server sent as a WebSocket frame.
std::string text_frame(std::istream& from) {
  char head[2] = {};
  from.read(head, sizeof head);
  std::string text(std::size_t(head[1]), ' ');
  from.read(text.data(), std::streamsize(text.size()));
  return text;
}

}  // namespace

TEST_CASE("Texts reach a page in the order in which threads send them") {
  Talkers talkers;
  WebServer server({.takes_signals = false}, talkers);
  talkers.server = &server;
  server.start();
  const std::string url = server.url(), prefix = "http://127.0.0.1:";
  REQUIRE(url.starts_with(prefix));
  const std::string port = url.substr(prefix.size(), url.find('/', prefix.size()) - prefix.size());
  tcp::iostream page("127.0.0.1", port);
  page.expires_after(std::chrono::seconds(30));
  page << "GET /ws HTTP/1.1\r\nHost: 127.0.0.1:" << port << "\r\nOrigin: http://127.0.0.1:" << port
       << "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
       << "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\n"
       << "Sec-WebSocket-Protocol: ringsplat.v1, token." << url.substr(url.find('#') + 1) << "\r\n\r\n"
       << std::flush;
  std::string line;
  REQUIRE(std::getline(page, line));
  REQUIRE(line == "HTTP/1.1 101 Switching Protocols\r");
  while (std::getline(page, line) && line != "\r") continue;
  CHECK(text_frame(page) == "first");
  CHECK(text_frame(page) == "second");
}
