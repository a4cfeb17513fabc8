// When a token may move, observed by a network that delivers one message at a time.
#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <random>
#include <set>

#include "net/mesh.hpp"
#include "support/catch.hpp"
#include "toy_engine.hpp"

using namespace ringsplat;
using namespace ringsplat::test;

namespace {

/// All GPs and Renderers of a layout, and the messages between them. Checks every message when a node posts
/// it and when it is delivered, which is late and in any order.
class WatchedNodes {
 public:
  WatchedNodes(const Layout& layout, const ProtocolOptions& protocol, std::uint64_t seed)
      : layout_(layout), random_(seed), of_renderer_(std::size_t(layout.renderers)) {
    const Post post = [this](Message message) { take_posted(std::move(message)); };
    for (int gp = 0; gp < layout.gps; ++gp) nodes_.push_back(make_gp({gp, layout, protocol, engine(), post}));
    for (int r = 0; r < layout.renderers; ++r)
      nodes_.push_back(make_renderer({r, layout, protocol, engine(), post}));
    // Some slices have nothing to send.
    const ToyFrame frame{.steps = 17,
                         .gps = layout.gps,
                         .renderers = layout.renderers,
                         .tiles = layout.renderers,
                         .empty_payloads = 0b1'0000'0001'0001'0001};
    for (const auto& node : nodes_) node->begin_frame(announcement(0, frame));
  }

  /// Runs until all nodes have reported.
  void run() {
    for (int turn = 0; reports_ < layout_.gps + layout_.renderers; ++turn) {
      REQUIRE(turn < 200000);
      nodes_[random_() % nodes_.size()]->advance();
      if (on_their_way_.empty() || random_() % 3 == 0) continue;
      const auto at = on_their_way_.begin() + std::ptrdiff_t(random_() % on_their_way_.size());
      Message message = std::move(*at);
      on_their_way_.erase(at);
      deliver(std::move(message));
    }
    REQUIRE(on_their_way_.empty());
  }

  int payloads() const { return payloads_; }
  /// Largest number of a Renderer's unaccepted payloads when its token moved.
  int most_not_accepted() const { return most_not_accepted_; }
  /// Most consecutive payloads that a token left before their accepts had reached the sending GPs.
  int most_left_behind() const { return most_left_behind_; }

 private:
  struct OfRenderer {
    int payloads = 0, accepts = 0, last_step = -1;
    std::set<std::uint32_t> heard_of;  ///< payloads whose accepts have arrived
    bool sent = false;                 ///< a payload was sent since the token last moved
    int left_behind = 0;               ///< consecutive payloads left behind
    bool ended = false;

    void move_token() {
      if (!std::exchange(sent, false)) return;
      left_behind = heard_of.contains(std::uint32_t(payloads - 1)) ? 0 : left_behind + 1;
    }
  };

  void take_posted(Message message) {
    const Header& h = message.header;
    if (h.to() == frame_buffer_id) {
      reports_ += h.kind == Kind::report;
      return;
    }
    const auto sequence = token_place(h) ? token_place(h)->sequence : fields_of<FrameEndFields>(h).payloads;
    OfRenderer& r = of_renderer_.at(std::size_t(token_place(h) ? token_place(h)->renderer : h.destination));
    switch (h.kind) {
      case Kind::payload:
        REQUIRE(sequence == std::uint32_t(r.payloads));
        REQUIRE(token_place(h)->step > r.last_step);
        r.last_step = token_place(h)->step;
        ++r.payloads;
        ++payloads_;
        r.sent = true;
        break;
      case Kind::accept:
        ++r.accepts;
        break;
      case Kind::frame_end:
      case Kind::token:
        REQUIRE_FALSE(r.ended);
        REQUIRE(sequence == std::uint32_t(r.payloads));
        r.move_token();
        most_not_accepted_ = std::max(most_not_accepted_, r.payloads - r.accepts);
        most_left_behind_ = std::max(most_left_behind_, r.left_behind);
        r.ended = h.kind == Kind::frame_end;
        break;
      default:
        FAIL("a " << name(h.kind) << " between nodes");
    }
    on_their_way_.push_back(std::move(message));
  }

  void deliver(Message message) {
    const Header& h = message.header;
    if (h.kind == Kind::accept)
      of_renderer_.at(std::size_t(h.source)).heard_of.insert(token_place(h)->sequence);
    const auto to =
        std::find_if(nodes_.begin(), nodes_.end(), [&](const auto& node) { return node->id() == h.to(); });
    REQUIRE(to != nodes_.end());
    (*to)->receive(std::move(message));
  }

  ToyEngine& engine() { return engines_.emplace_back(); }

  Layout layout_;
  std::mt19937_64 random_;
  std::deque<ToyEngine> engines_;  ///< one for each node
  std::vector<std::unique_ptr<Node>> nodes_;
  std::vector<Message> on_their_way_;
  std::vector<OfRenderer> of_renderer_;
  int reports_ = 0, payloads_ = 0, most_not_accepted_ = 0, most_left_behind_ = 0;
};

const Layout layouts[] = {{1, 1}, {2, 1}, {3, 2}, {4, 3}, {3, 3, Placement::colocated}};

}  // namespace

TEST_CASE("without sending ahead no token moves before its payload's accept has arrived") {
  for (const auto& layout : layouts)
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
      INFO(fmt::format("{} GPs, {} Renderers, seed {}", layout.gps, layout.renderers, seed));
      WatchedNodes nodes(
          layout, {.slots = 1 + int(seed % 4), .look_ahead = 1 + int(seed % 2), .send_ahead = 0}, seed);
      nodes.run();
      CHECK(nodes.payloads() > 5 * layout.renderers);
      CHECK(nodes.most_not_accepted() == 0);
      CHECK(nodes.most_left_behind() == 0);
    }
}

TEST_CASE("a token leaves as many payloads behind as it may send ahead, and no more than have slots") {
  for (const auto& layout : layouts)
    for (const int send_ahead : {1, 2, 5})
      for (const int slots : {1, 2, 4}) {
        int most = 0;
        for (std::uint64_t seed = 0; seed < 6; ++seed) {
          INFO(fmt::format("{} GPs, {} Renderers, {} ahead, {} slots, seed {}", layout.gps, layout.renderers,
                           send_ahead, slots, seed));
          WatchedNodes nodes(layout, {.slots = slots, .look_ahead = 2, .send_ahead = send_ahead}, seed);
          nodes.run();
          CHECK(nodes.most_not_accepted() <= slots);
          most = std::max(most, nodes.most_left_behind());
        }
        CHECK(most == std::min(send_ahead, slots));
      }
}

TEST_CASE("in a mesh tokens wait for their accepts whatever may be sent ahead") {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    WatchedNodes nodes(mesh_layout(2, 2, 2), {.slots = 3, .send_ahead = 3}, seed);
    nodes.run();
    CHECK(nodes.payloads() > 10);
    CHECK(nodes.most_not_accepted() == 0);
    CHECK(nodes.most_left_behind() == 0);
  }
}
