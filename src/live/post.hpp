#pragma once
#include <optional>
#include <utility>

#include "base/archive.hpp"
#include "base/clock.hpp"
#include "net/transport.hpp"
#include "session/render_frames.hpp"

namespace ringsplat {

/// Messages between a simulation's ranks and those that are set aside to draw, who do not wait for each
/// other.
class Post {
 public:
  explicit Post(Session& session)
      : session_(session),
        transport_(SessionParts::transport(session)),
        number_(SessionParts::divide(session, true)) {}
  /// What was sent must have left before its memory goes.
  ~Post() {
    const double until = now_seconds() + 60;
    while (!transport_.sends_done() && now_seconds() < until) transport_.wait_next();
    SessionParts::divide(session_, false);
  }

  /// `wire`: room for a header, and what comes before the values.
  template <class... Values>
  void send(int rank, Kind kind, Bytes wire, const Values&... values) {
    const Bytes more = to_bytes(values...);
    wire.insert(wire.end(), more.begin(), more.end());
    const NodeId from{Role::host, session_.rank()}, to{Role::host, rank};
    transport_.send(rank, Message(make_header(kind, from, to, number_), std::move(wire)));
  }
  /// A message that has come, or comes. What was sent before this was made is forgotten.
  std::optional<Message> receive(bool waits = false) {
    for (;; transport_.wait_next()) {
      transport_.sends_done();
      auto message = transport_.receive();
      if (message) transport_.note_progress();
      if (message && message->header.frame == number_) return message;
      if (!waits) return std::nullopt;
    }
  }

 private:
  Session& session_;
  Transport& transport_;
  const std::int64_t number_;
};

}  // namespace ringsplat
