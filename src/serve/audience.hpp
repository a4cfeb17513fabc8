#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "serve/picture_maker.hpp"
#include "serve/viewer.hpp"

namespace ringsplat::serve {

/// A picture's message, and what it shows.
struct SentPicture {
  std::shared_ptr<const std::string> message;
  PictureHead head;
  SceneState state;
  std::uint64_t scene = 0;  ///< the same for pictures of the same view in the same size
};

/// Who is connected, and who drives: the first to come does, and when it goes the one that has been here
/// longest. Sends them texts and pictures, as fast as each acknowledges them. Not for several threads at
/// once.
class Audience {
 public:
  /// Pictures that a client may have unacknowledged.
  static constexpr int most_unacknowledged = 2;

  using Send = std::function<void(ClientId client, bool binary, std::shared_ptr<const std::string> bytes)>;
  explicit Audience(Send send) : send_(std::move(send)) {}

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
  /// The driver's; most_unacknowledged when there is none.
  int unacknowledged() const {
    return driver_ ? int(members_.at(*driver_).unacknowledged.size()) : most_unacknowledged;
  }
  /// The driver has seen no picture yet.
  bool has_newcomer() const { return driver_ && members_.at(*driver_).last == 0; }
  /// The picture that was shown last.
  const std::optional<SentPicture>& last() const { return last_; }

  void say(const std::string& text) const {
    const auto shared = std::make_shared<const std::string>(text);
    for (const auto& [client, member] : members_) send_(client, false, shared);
  }
  void say_who_drives() const {
    for (const auto& [client, member] : members_)
      say_to(client, {{"type", "driver"}, {"you", drives(client)}, {"viewers", size()}});
  }

  /// Numbers a picture and sends it to all who can take one.
  void show(SentPicture&& picture) {
    picture.head.number = last_ ? last_->head.number + 1 : 1;
    picture.head.pictures_a_second = pictures_a_second();
    const std::string_view file = std::string_view(*picture.message).substr(sizeof picture.head);
    picture.message = std::make_shared<const std::string>(picture_message(picture.head, file));
    last_ = std::move(picture);
    for (const auto& [client, member] : members_) catch_up(client);
  }
  /// A client can take another picture. One that could not take the last, as it is slow, gets it now.
  void acknowledge(ClientId client, std::uint32_t picture) {
    if (const auto found = members_.find(client); found != members_.end())
      found->second.unacknowledged.erase(picture);
    catch_up(client);
  }
  /// Sends the last picture to a client that lacks it and can take it; watchers are told before what it
  /// shows.
  void catch_up(ClientId client) {
    const auto found = members_.find(client);
    if (!last_ || found == members_.end()) return;
    Member& member = found->second;
    if (member.last == last_->head.number || int(member.unacknowledged.size()) >= most_unacknowledged) return;
    member.last = last_->head.number;
    member.unacknowledged.insert(member.last);
    const bool told = std::exchange(member.scene, last_->scene) == last_->scene;
    if (!told && !drives(client)) say_to(client, {{"type", "state"}, {"state", to_json(last_->state)}});
    send_(client, true, last_->message);
  }

 private:
  struct Member {
    std::set<std::uint32_t> unacknowledged;
    std::uint32_t last = 0;   ///< picture that it was sent
    std::uint64_t scene = 0;  ///< of that picture
  };
  using Clock = std::chrono::steady_clock;

  /// Of the last second, the one that is shown now included.
  float pictures_a_second() {
    const auto now = Clock::now();
    shown_.push_back(now);
    while (now - shown_.front() > std::chrono::seconds(1)) shown_.pop_front();
    if (shown_.size() < 2) return 0;
    const std::chrono::duration<float> span = now - shown_.front();
    return float(shown_.size() - 1) / std::max(span.count(), 1e-3F);
  }

  void say_to(ClientId client, const nlohmann::json& message) const {
    send_(client, false, std::make_shared<const std::string>(text_of(message)));
  }

  Send send_;
  std::map<ClientId, Member> members_;  ///< in the order in which they came
  std::optional<ClientId> driver_;
  std::optional<SentPicture> last_;
  std::deque<Clock::time_point> shown_;
};

}  // namespace ringsplat::serve
