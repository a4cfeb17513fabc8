#include "net/mesh_transport.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/clock.hpp"
#include "net/message.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {

namespace {

/// Names a (direction, buffer class) of the rank that a credit goes to.
std::uint32_t channel(Direction direction, int buffer_class) {
  return static_cast<std::uint32_t>(direction) * buffer_classes + static_cast<std::uint32_t>(buffer_class);
}

std::string describe(const Header& h) {
  const auto place = token_place(h);
  return fmt::format("a {} from {} to {} (frame {}{})", name(h.kind), to_string(h.from()), to_string(h.to()),
                     h.frame, place ? fmt::format(", step {}", place->step) : std::string());
}

}  // namespace

bool travels_by_mesh(Kind kind) {
  switch (kind) {
    case Kind::token:
    case Kind::payload:
    case Kind::accept:
    case Kind::frame_end:
    case Kind::tile:
    case Kind::report:
      return true;
    default:
      return false;
  }
}

MeshRouter::MeshRouter(const Layout& mesh, int slots, Transport& transport, Observer observer)
    : mesh_(mesh), slots_(slots), transport_(transport), observer_(std::move(observer)) {
  for (const Link& link : links_from(mesh_, transport.rank())) {
    out_.push_back({link, neighbour(mesh_, link.from, link.direction).value(), {}, {}});
    out_.back().free_slots.fill(slots);
  }
}

bool MeshRouter::OutLink::in_use(int slots) const {
  for (std::size_t c = 0; c < free_slots.size(); ++c)
    if (free_slots[c] < slots || !waiting[c].empty()) return true;
  return false;
}

void MeshRouter::post(Message message) { forward(std::move(message), std::nullopt); }

std::optional<Message> MeshRouter::take(Message message) {
  const Header& h = message.header;
  if (h.kind == Kind::credit) {
    take_credit(h);
    return std::nullopt;
  }
  if (!travels_by_mesh(h.kind)) return message;
  const Hop came_by = hop_into_here(h);
  if (mesh_.rank_of(h.to()) == transport_.rank()) {
    free_slot(came_by);
    return message;
  }
  forward(std::move(message), came_by);
  return std::nullopt;
}

Hop MeshRouter::hop_into_here(const Header& h) const {
  for (const Hop& hop : route(mesh_, h.from(), h.to()))
    if (hop.to == transport_.rank()) return hop;
  throw RunError(fmt::format("rank {} got {}, which does not pass here", transport_.rank(), describe(h)));
}

Hop MeshRouter::hop_from_here(const Header& h) const {
  for (const Hop& hop : route(mesh_, h.from(), h.to()))
    if (hop.link.from == transport_.rank()) return hop;
  throw RunError(
      fmt::format("rank {} cannot hand on {}, which does not pass here", transport_.rank(), describe(h)));
}

MeshRouter::OutLink& MeshRouter::out_link(Direction direction) {
  return *std::find_if(out_.begin(), out_.end(),
                       [&](const OutLink& out) { return out.link.direction == direction; });
}

std::vector<LinkCounts>& MeshRouter::counts_of(std::int64_t frame) {
  auto& counts = counts_[frame];
  if (counts.empty())
    for (const auto& each : out_) counts.push_back({.link = each.link});
  return counts;
}

LinkCounts& MeshRouter::counts_of(const OutLink& out, std::int64_t frame) {
  return counts_of(frame)[static_cast<std::size_t>(&out - out_.data())];
}

void MeshRouter::forward(Message message, std::optional<Hop> came_by) {
  const Header& h = message.header;
  const Hop hop = hop_from_here(h);
  OutLink& out = out_link(hop.link.direction);
  const auto buffer_class = static_cast<std::size_t>(hop.buffer_class);
  LinkCounts& counts = counts_of(out, h.frame);
  ++counts.messages;
  counts.bytes += sizeof(Header) + h.bytes;
  if (h.kind == Kind::payload) {
    ++counts.payloads;
    counts.payload_bytes += sizeof(Header) + h.bytes;
  }
  if (out.in_use(slots_)) ++counts.shared;
  if (out.free_slots[buffer_class] > 0) {
    send(out, hop.buffer_class, {std::move(message), came_by});
    return;
  }
  ++counts.waited;
  out.waiting[buffer_class].push_back({std::move(message), came_by, now_seconds()});
}

void MeshRouter::send(OutLink& out, int buffer_class, Waiting waiting) {
  --out.free_slots[static_cast<std::size_t>(buffer_class)];
  if (waiting.since > 0)
    counts_of(out, waiting.message.header.frame).wait_seconds += now_seconds() - waiting.since;
  if (observer_) observer_(out.link, waiting.message.header);
  transport_.send(out.to, std::move(waiting.message));
  if (waiting.came_by) free_slot(*waiting.came_by);
}

void MeshRouter::free_slot(const Hop& came_by) {
  ++owed_credits_[{came_by.link.from, channel(came_by.link.direction, came_by.buffer_class)}];
}

void MeshRouter::return_credits() {
  for (const auto& [to, slots] : std::exchange(owed_credits_, {}))
    transport_.send(to.first, Message(make_header({Role::host, transport_.rank()}, {Role::host, to.first}, 0,
                                                  CreditFields{.channel = to.second, .slots = slots})));
}

void MeshRouter::take_credit(const Header& h) {
  const auto [channel, slots] = fields_of<CreditFields>(h);
  const auto direction = channel / buffer_classes, buffer_class = channel % buffer_classes;
  const auto found = std::find_if(out_.begin(), out_.end(), [&](const OutLink& out) {
    return out.to == h.source && static_cast<std::uint32_t>(out.link.direction) == direction;
  });
  if (found == out_.end() || slots == 0 || slots > std::uint32_t(slots_ - found->free_slots[buffer_class]))
    throw RunError(fmt::format("rank {} gave rank {} {} slot(s) back that it had not taken", h.source,
                               transport_.rank(), slots));
  found->free_slots[buffer_class] += static_cast<int>(slots);
  auto& waiting = found->waiting[buffer_class];
  while (!waiting.empty() && found->free_slots[buffer_class] > 0) {
    Waiting first = std::move(waiting.front());
    waiting.pop_front();
    send(*found, static_cast<int>(buffer_class), std::move(first));
  }
}

bool MeshRouter::idle() const {
  return owed_credits_.empty() &&
         std::none_of(out_.begin(), out_.end(), [&](const OutLink& out) { return out.in_use(slots_); });
}

std::string MeshRouter::waiting_for() const {
  std::string all;
  const auto say = [&](const std::string& line) { all += (all.empty() ? "" : "; ") + line; };
  for (const auto& out : out_)
    for (std::size_t c = 0; c < out.waiting.size(); ++c) {
      const int taken = slots_ - out.free_slots[c];
      if (!out.waiting[c].empty())
        say(fmt::format(
            "{} message(s) wait at link {} for rank {} to free one of {} slot(s), the first is {}",
            out.waiting[c].size(), name(mesh_, out.link), out.to, slots_,
            describe(out.waiting[c].front().message.header)));
      else if (taken > 0)
        say(fmt::format("rank {} has not yet handed on {} message(s) from link {}", out.to, taken,
                        name(mesh_, out.link)));
    }
  return all;
}

std::vector<LinkCounts> MeshRouter::take_counts(std::int64_t frame) {
  std::vector<LinkCounts> counts = std::move(counts_of(frame));
  counts_.erase(frame);
  return counts;
}

namespace {

[[noreturn]] void refuse(NodeId from, std::int64_t frame) {
  throw RunError(
      fmt::format("{} reported its links for frame {} without being asked", to_string(from), frame));
}

}  // namespace

MeshTransport::MeshTransport(const Layout& mesh, int slots, Transport& network, MeshRouter::Observer observer)
    : TransportDecorator(network), mesh_(mesh), router_(mesh, slots, network, std::move(observer)) {}

void MeshTransport::send(int destination, Message message) {
  if (travels_by_mesh(message.header.kind))
    router_.post(std::move(message));
  else
    inner_.send(destination, std::move(message));
}

std::optional<Message> MeshTransport::receive() {
  while (auto message = inner_.receive()) {
    check(message->header, mesh_);
    message = router_.take(std::move(*message));
    if (message && message->header.kind == Kind::link_query)
      pass_on_query(*message);
    else if (message && message->header.kind == Kind::link_report)
      take_report(*message);
    else if (message)
      return message;
    relayed_ = true;
  }
  router_.return_credits();
  return std::nullopt;
}

void MeshTransport::collect_counts(std::int64_t frame, TakeCounts take) {
  collected_.push_back({frame, std::move(take), {}});
  pass_on_query(Message(make_header(Kind::link_query, {Role::host, rank()}, {Role::host, rank()}, frame)));
}

/// Queries and reports bypass the mesh: they would count themselves.
void MeshTransport::pass_on_query(const Message& query) {
  for (const int child : announcement_children(rank(), mesh_.ranks())) {
    Message copy = query;
    copy.header.destination = child;
    inner_.send(child, std::move(copy));
  }
  const std::int64_t frame = query.header.frame;
  std::vector<LinkCounts> counts = router_.take_counts(frame);
  if (rank() == 0)
    report(frame, 0, std::move(counts));
  else
    inner_.send(0, Message(make_header(Kind::link_report, {Role::host, rank()}, {Role::host, 0}, frame),
                           encode(counts)));
}

void MeshTransport::take_report(const Message& message) {
  const Header& h = message.header;
  if (h.source_role != Role::host) refuse(h.from(), h.frame);
  report(h.frame, h.source, decode_link_counts(message.body(), mesh_, h.source));
}

void MeshTransport::report(std::int64_t frame, int rank, std::vector<LinkCounts> counts) {
  const auto asked = std::find_if(collected_.begin(), collected_.end(),
                                  [&](const Collected& c) { return c.frame == frame; });
  if (asked == collected_.end() || !asked->counts.emplace(rank, std::move(counts)).second)
    refuse({Role::host, rank}, frame);
  while (!collected_.empty() && int(collected_.front().counts.size()) == mesh_.ranks()) {
    const Collected known = std::move(collected_.front());
    collected_.pop_front();
    std::vector<LinkCounts> all;
    for (const auto& [of, its] : known.counts) all.insert(all.end(), its.begin(), its.end());
    known.take(std::move(all));
  }
}

std::string MeshTransport::waiting_for() const {
  std::string all = router_.waiting_for();
  if (!collected_.empty())
    all += fmt::format("{}{} rank(s) have not yet reported their links for frame {}", all.empty() ? "" : "; ",
                       mesh_.ranks() - int(collected_.front().counts.size()), collected_.front().frame);
  return all;
}

void MeshTransport::wait_between_frames(const Sleep& sleep) {
  if (collected_.empty())
    inner_.wait_between_frames(sleep);
  else
    inner_.wait_next();
}

}  // namespace ringsplat
