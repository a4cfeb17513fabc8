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

  void add(ClientId client) {
    members_[client];
    if (!driver_) driver_ = client;
  }
  void remove(ClientId client) {
    members_.erase(client);
    if (driver_ != client) return;
    driver_.reset();
    if (!members_.empty()) driver_ = members_.begin()->first;
  }
  void drive(ClientId client) {
    if (members_.contains(client)) driver_ = client;
  }

  bool drives(ClientId client) const { return driver_ == client; }
  int size() const { return int(members_.size()); }
  std::vector<ClientId> all() const {
    return those([](const Member&) { return true; });
  }

  /// The driver's; most_unacknowledged when there is none.
  int unacknowledged() const {
    return driver_ ? int(members_.at(*driver_).unacknowledged.size()) : most_unacknowledged;
  }
  void sent(ClientId client, std::uint32_t picture) {
    if (const auto found = members_.find(client); found != members_.end())
      found->second.unacknowledged.insert(found->second.last = picture);
  }
  void acknowledge(ClientId client, std::uint32_t picture) {
    if (const auto found = members_.find(client); found != members_.end())
      found->second.unacknowledged.erase(picture);
  }
  /// Those that can take another picture.
  std::vector<ClientId> takers() const { return those(can_take); }
  /// True when a client can take a picture and was not yet sent that one or a later one.
  bool lacks(ClientId client, std::uint32_t picture) const {
    const auto found = members_.find(client);
    return found != members_.end() && found->second.last < picture && can_take(found->second);
  }
  /// True once for each scene: a watcher must be told of it before it is shown.
  bool must_learn(ClientId client, std::uint64_t scene) {
    const auto found = members_.find(client);
    if (found == members_.end() || found->second.scene == scene) return false;
    found->second.scene = scene;
    return client != driver_;
  }

 private:
  struct Member {
    std::set<std::uint32_t> unacknowledged;
    std::uint32_t last = 0;   ///< picture that it was sent
    std::uint64_t scene = 0;  ///< that it was last told of
  };

  static bool can_take(const Member& member) {
    return int(member.unacknowledged.size()) < most_unacknowledged;
  }
  std::vector<ClientId> those(bool (*wanted)(const Member&)) const {
    std::vector<ClientId> clients;
    for (const auto& [client, member] : members_)
      if (wanted(member)) clients.push_back(client);
    return clients;
  }

  std::map<ClientId, Member> members_;  ///< in the order in which they came
  std::optional<ClientId> driver_;
};

}  // namespace ringsplat::serve
