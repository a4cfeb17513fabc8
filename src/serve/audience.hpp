#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "serve/web_server.hpp"

namespace ringsplat::serve {

/// Who is connected, who drives, and which pictures each has not yet acknowledged. The first to come drives;
/// when it goes the one that has been here longest does. Not for several threads at once.
class Audience {
 public:
  /// Pictures that a client may have unacknowledged.
  static constexpr int most_unacknowledged = 2;

  void add(ClientId client);
  void remove(ClientId client);
  void drive(ClientId client);

  bool has(ClientId client) const { return members_.contains(client); }
  bool drives(ClientId client) const { return driver_ == client; }
  std::optional<ClientId> driver() const { return driver_; }
  int size() const { return int(members_.size()); }
  std::vector<ClientId> all() const;

  /// The driver's; most_unacknowledged when there is none.
  int unacknowledged() const;
  void sent(ClientId client, std::uint32_t picture);
  void acknowledge(ClientId client, std::uint32_t picture);
  /// Those that can take another picture.
  std::vector<ClientId> takers() const;
  /// True when a client can take a picture and was not yet sent that one or a later one.
  bool lacks(ClientId client, std::uint32_t picture) const;
  /// True once for each scene: a watcher must be told of it before it is shown.
  bool must_learn(ClientId client, std::uint64_t scene);

 private:
  struct Member {
    std::set<std::uint32_t> unacknowledged;
    std::uint32_t last = 0;   ///< picture that it was sent
    std::uint64_t scene = 0;  ///< that it was last told of
  };
  std::map<ClientId, Member> members_;  ///< in the order in which they came
  std::optional<ClientId> driver_;
};

}  // namespace ringsplat::serve
