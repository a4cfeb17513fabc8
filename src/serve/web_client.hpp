#pragma once
#include <algorithm>
#include <deque>

#include "serve/web_shared.hpp"

namespace ringsplat::serve::web {

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
    // A large file is sent in fragments, between which pings can go: without their answers a slow client
    // would be taken for a dead one.
    stream_.auto_fragment(true);
    stream_.write_buffer_bytes(std::size_t{1} << 16);
    stream_.set_option(websocket::stream_base::timeout{shared_.limits.patience, shared_.limits.silence,
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
    if (waiting_ > shared_.limits.unsent_bytes) {
      cut_off();
      return;
    }
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
                          self->outgoing_.pop_front();
                          if (self->outgoing_.empty()) {
                            if (self->closing_) self->start_closing();
                            return;
                          }
                          self->waiting_ -= self->outgoing_.front().bytes->size();
                          self->write();
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
  std::size_t waiting_ = 0;        ///< bytes behind the first
  ClientId id_;
  double allowance_;  ///< messages that may be read now
  Clock::time_point counted_ = Clock::now();
  bool open_ = false, closing_ = false, cut_off_ = false;
};

}  // namespace ringsplat::serve::web
