#include "net/mesh_transport.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "net/layout_nodes.hpp"
#include "ringsplat/base/error.hpp"

namespace ringsplat {
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
  const auto ranks = std::size_t(mesh_.ranks());
  collected_.push_back({frame, std::move(take), std::vector<std::vector<LinkCounts>>(ranks),
                        std::vector<bool>(ranks), mesh_.ranks()});
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
  if (asked == collected_.end() || asked->reported[std::size_t(rank)]) refuse({Role::host, rank}, frame);
  asked->counts[std::size_t(rank)] = std::move(counts);
  asked->reported[std::size_t(rank)] = true;
  --asked->reports_missing;
  while (!collected_.empty() && collected_.front().reports_missing == 0) {
    const Collected known = std::move(collected_.front());
    collected_.pop_front();
    std::vector<LinkCounts> all;
    for (const auto& of_rank : known.counts) all.insert(all.end(), of_rank.begin(), of_rank.end());
    known.take(std::move(all));
  }
}

std::string MeshTransport::waiting_for() const {
  std::string all = router_.waiting_for();
  if (!collected_.empty())
    all += fmt::format("{}{} rank(s) have not yet reported their links for frame {}", all.empty() ? "" : "; ",
                       collected_.front().reports_missing, collected_.front().frame);
  return all;
}

void MeshTransport::wait_between_frames(const Sleep& sleep) {
  if (collected_.empty())
    inner_.wait_between_frames(sleep);
  else
    inner_.wait_next();
}

}  // namespace ringsplat
