#pragma once
// The web server's parts, which only web_server.cpp includes: Beast takes half a minute to compile.
#include <list>
#include <map>
#include <memory>
#include <optional>
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

/// What all connections share; only the server's thread uses it.
struct Shared {
  ServerLimits limits;
  ServerEvents events;
  std::optional<Access> access;
  std::string frame_ancestors;  ///< a list of the Content-Security-Policy
  std::string packed_page, page_tag;
  std::map<ClientId, std::weak_ptr<Client>> clients;
  int pages = 0;  ///< connections that have shown the token
  /// All others, in the order in which they came; each leaves the list when it goes.
  std::list<Visitor*> visitors;
  ClientId last_client = 0;
  bool ending = false;
  asio::io_context io{1};  ///< goes first, with handlers that hold connections
};

/// A page's place among those that are allowed.
class Place {
 public:
  explicit Place(Shared& shared) : shared_(&shared) { ++shared.pages; }
  ~Place() {
    if (shared_ != nullptr) --shared_->pages;
  }
  Place(Place&& other) noexcept : shared_(std::exchange(other.shared_, nullptr)) {}
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;
  Place& operator=(Place&&) = delete;

 private:
  Shared* shared_;
};

}  // namespace ringsplat::serve::web
