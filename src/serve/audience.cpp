#include "serve/audience.hpp"

namespace ringsplat::serve {

void Audience::add(ClientId client) {
  members_[client];
  if (!driver_) driver_ = client;
}

void Audience::remove(ClientId client) {
  members_.erase(client);
  if (driver_ != client) return;
  driver_.reset();
  if (!members_.empty()) driver_ = members_.begin()->first;
}

void Audience::drive(ClientId client) {
  if (has(client)) driver_ = client;
}

std::vector<ClientId> Audience::all() const {
  std::vector<ClientId> clients;
  for (const auto& [client, member] : members_) clients.push_back(client);
  return clients;
}

int Audience::unacknowledged() const {
  return driver_ ? int(members_.at(*driver_).unacknowledged.size()) : most_unacknowledged;
}

void Audience::sent(ClientId client, std::uint32_t picture) {
  if (const auto found = members_.find(client); found != members_.end())
    found->second.unacknowledged.insert(found->second.last = picture);
}

void Audience::acknowledge(ClientId client, std::uint32_t picture) {
  if (const auto found = members_.find(client); found != members_.end())
    found->second.unacknowledged.erase(picture);
}

std::vector<ClientId> Audience::takers() const {
  std::vector<ClientId> clients;
  for (const auto& [client, member] : members_)
    if (int(member.unacknowledged.size()) < most_unacknowledged) clients.push_back(client);
  return clients;
}

bool Audience::lacks(ClientId client, std::uint32_t picture) const {
  const auto found = members_.find(client);
  return found != members_.end() && found->second.last < picture &&
         int(found->second.unacknowledged.size()) < most_unacknowledged;
}

bool Audience::must_learn(ClientId client, std::uint64_t scene) {
  const auto found = members_.find(client);
  if (found == members_.end() || found->second.scene == scene) return false;
  found->second.scene = scene;
  return client != driver_;
}

}  // namespace ringsplat::serve
